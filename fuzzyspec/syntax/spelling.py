"""Near spellings of keywords."""

from __future__ import annotations

from collections.abc import Iterable


def near(word: str, keywords: Iterable[str]) -> list[str]:
    """The keywords that ``word`` may be a slip of, nearest first: another case, or one or two letters off."""
    if len(word) > 20:
        return []
    scored = sorted((distance(word.lower(), k), k) for k in keywords)
    return [k for d, k in scored if d <= (0 if len(k) < 3 else 1 if len(k) < 6 else 2) or _likely(word.lower(), k)]


def _likely(word: str, keyword: str) -> bool:
    """A keyword cut short, or one of two letters in the wrong order."""
    return (len(word) > 2 and keyword.startswith(word)) or _swapped(word, keyword)


def _swapped(word: str, keyword: str) -> bool:
    """Two letters in the wrong order, which is all that a keyword of two letters can be told by."""
    return len(word) == len(keyword) == 2 and word == keyword[::-1]


def distance(a: str, b: str) -> int:
    """Letters to insert, drop, change or swap with their neighbour to get from one word to the other."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, start=1):
        earlier, before = before, row
        row = [i]
        for j, y in enumerate(b, start=1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, earlier[j - 2] + 1)
            row.append(cost)
    return row[-1]
