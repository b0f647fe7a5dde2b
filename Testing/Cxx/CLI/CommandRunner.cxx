#include "CommandRunner.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>

#ifdef _WIN32
#include <process.h>
#else
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace innergs::test {
namespace {

std::string readFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string quote(const std::string& word) {
#ifdef _WIN32
  return "\"" + word + "\"";
#else
  std::string quoted = "'";
  for (const char c : word)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
#endif
}

int processId() {
#ifdef _WIN32
  return _getpid();
#else
  return static_cast<int>(getpid());
#endif
}

} // namespace

void CommandTest::SetUp() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "-" + test->name();
  std::replace(name.begin(), name.end(), '/', '-');
  folder_ = std::filesystem::temp_directory_path() / ("innergs-" + std::to_string(processId()) + "-" + name);
  std::filesystem::create_directories(folder_ / "out");
}

void CommandTest::TearDown() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Outcome CommandTest::run(const std::vector<std::string>& arguments, const std::string& prefix) const {
  std::string command = prefix + quote(INNERGS_COMMAND);
  for (const auto& argument : arguments)
    command += " " + quote(argument);
  command += " > " + quote(path("stdout.txt")) + " 2> " + quote(path("stderr.txt"));
#ifdef _WIN32
  const int status = std::system(("\"" + command + "\"").c_str());
#else
  const int raw = std::system(command.c_str());
  const int status = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
#endif
  return {status, contents("stdout.txt"), contents("stderr.txt")};
}

std::string CommandTest::contents(const std::string& name) const {
  return readFile(folder_ / name);
}

void CommandTest::write(const std::string& name, const std::string& bytes) const {
  std::ofstream(folder_ / name, std::ios::binary) << bytes;
}

std::vector<std::string> CommandTest::filesIn(const std::string& name) const {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / name))
    files.push_back(entry.path().filename().string());
  return files;
}

void expectSuccess(const Outcome& outcome) {
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
}

void expectOneSentence(const Outcome& outcome, int exitCode, const std::string& mention) {
  EXPECT_EQ(outcome.exitCode, exitCode) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.substr(0, 9), "innergs: ") << outcome.err;
  EXPECT_GT(outcome.err.size(), 25u) << "not a sentence: " << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(mention), std::string::npos)
      << "expected '" << mention << "' in: " << outcome.err;
}

std::vector<std::string> quickly(std::vector<std::string> arguments) {
  for (const char* option : {"--preset", "fast", "--gaussians", "400", "--iterations", "6", "--threads", "2"})
    arguments.emplace_back(option);
  return arguments;
}

} // namespace innergs::test
