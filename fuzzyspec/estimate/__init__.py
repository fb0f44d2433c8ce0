"""What a program will cost, without a compiler: what it does is counted and weighed, target by target."""
