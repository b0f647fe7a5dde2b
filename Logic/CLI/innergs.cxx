#include "CLI/Command.h"
#include "CLI/Version.h"

#include "Core/Base/Failure.h"
#include "IO/LibraryMessages.h"

#include <cstdio>
#include <string>
#include <vector>

namespace {

// Prints one line, whatever the message contains, so that scripts can rely on it.
int fail(innergs::cli::ExitCode code, std::string sentence) {
  for (char& c : sentence)
    if (c == '\n' || c == '\r') c = ' ';
  std::fprintf(stderr, "innergs: %s\n", sentence.c_str());
  return code;
}

// Names an unknown subcommand, which the parser does not.
void checkName(const std::string& name, const std::vector<innergs::cli::Subcommand>& commands) {
  std::string known;
  for (const auto& command : commands) {
    if (command.app->get_name() == name) return;
    known += (known.empty() ? "" : ", ") + command.app->get_name();
  }
  throw CLI::ValidationError("'" + name + "' is not a command", "give one of " + known);
}

int run(int argc, char** argv) {
  using namespace innergs::cli;
  CLI::App app("Turns medical image slices into a continuous volume of 3D Gaussians.\n"
               "Research software, not a medical device.");
  app.set_version_flag("--version", "innergs " INNERGS_VERSION);
  app.require_subcommand(1);
  app.footer("Exit codes: 0 success, 1 error in input or run, 2 wrong usage, 130 interrupted (Ctrl-C).\n"
             "'innergs COMMAND --help' explains a command, with examples.");
  std::vector<Subcommand> commands;
  for (const auto add : {addReconstruct, addSlice, addResample, addInterpolate, addSegment, addSimulate,
                         addEvaluate, addExperiment, addInfo})
    commands.push_back(add(app));
  try {
    if (argc > 1 && argv[1][0] != '-') checkName(argv[1], commands);
    app.parse(argc, argv);
    for (const auto& command : commands)
      if (*command.app) return command.run();
    return Success;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
    return fail(Usage, std::string(error.what()) + " (see 'innergs --help')");
  }
}

} // namespace

int main(int argc, char** argv) {
  using namespace innergs::cli;
  innergs::dropLibraryMessages();
  try {
    return run(argc, argv);
  } catch (...) {
    const innergs::Failure failure = innergs::failureOf();
    return fail(failure.code == innergs::ErrorCode::Cancelled ? Interrupted : Failure, failure.sentence);
  }
}
