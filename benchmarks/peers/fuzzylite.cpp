// Evaluates an engine over rows of inputs and prints the outputs, then the processor's nanoseconds an evaluation.
// Usage: fuzzylite ENGINE.fll CASES REPEATS    (CASES: doubles as text, a row a line)
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <vector>

#include <fl/Headers.h>

// The name by which callgrind is told what to count.
extern "C" __attribute__((noinline)) void evaluate_rows(
    fl::Engine *engine, const std::vector<double> *rows, std::vector<double> *found)
{
    const std::size_t in = engine->numberOfInputVariables(), out = engine->numberOfOutputVariables();
    for (std::size_t at = 0; at + in <= rows->size(); at += in) {
        for (std::size_t k = 0; k < in; ++k) {
            engine->getInputVariable(k)->setValue((*rows)[at + k]);
        }
        engine->process();
        for (std::size_t k = 0; k < out; ++k) {
            found->push_back(engine->getOutputVariable(k)->getValue());
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        return 2;
    }
    std::unique_ptr<fl::Engine> engine(fl::FllImporter().fromFile(argv[1]));
    std::vector<double> rows, found;
    std::ifstream cases(argv[2]);
    for (double value; cases >> value;) {
        rows.push_back(value);
    }
    const std::size_t n = rows.size() / engine->numberOfInputVariables();
    const int repeats = std::atoi(argv[3]);
    const std::clock_t start = std::clock();
    for (int k = 0; k < repeats; ++k) {
        found.clear();
        evaluate_rows(engine.get(), &rows, &found);
    }
    const double took = 1e9 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    for (double value : found) {
        std::printf("%.17g\n", value);
    }
    std::printf("%.17g\n", took / (static_cast<double>(n) * repeats));
    return 0;
}
