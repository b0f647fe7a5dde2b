#pragma once
#include <CLI/CLI.hpp>

#include <functional>

namespace innergs::cli {

enum ExitCode { Success = 0, Failure = 1, Usage = 2, Interrupted = 130 };

/// Runs a subcommand whose options have been parsed; returns the exit code, throws Error.
using Command = std::function<int()>;

/// A subcommand and what it runs. Each function below adds one to `app`.
struct Subcommand {
  CLI::App* app;
  Command run;
};
Subcommand addReconstruct(CLI::App& app);
Subcommand addSlice(CLI::App& app);
Subcommand addResample(CLI::App& app);
Subcommand addInterpolate(CLI::App& app);
Subcommand addSegment(CLI::App& app);
Subcommand addSimulate(CLI::App& app);
Subcommand addEvaluate(CLI::App& app);
Subcommand addExperiment(CLI::App& app);
Subcommand addInfo(CLI::App& app);

} // namespace innergs::cli
