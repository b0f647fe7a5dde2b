#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace innergs::test {

/// A command's exit code and output.
struct Outcome {
  int exitCode = -1;
  std::string out, err;
};

/// Tests the built command in a separate folder, removed afterwards.
class CommandTest : public testing::Test {
protected:
  void SetUp() override;
  void TearDown() override;

  /// Runs `innergs` as a shell would; `prefix` goes before the command (POSIX shell text).
  Outcome run(const std::vector<std::string>& arguments, const std::string& prefix = "") const;
  /// A path in the test's folder, as text.
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  std::string contents(const std::string& name) const;
  void write(const std::string& name, const std::string& bytes) const;
  /// Names of all files below a subfolder of the test's folder.
  std::vector<std::string> filesIn(const std::string& name) const;

  std::filesystem::path folder_;
};

void expectSuccess(const Outcome& outcome);

/// What every failure must look like: this exit code, one line "innergs: <sentence>" on stderr, nothing on
/// stdout.
void expectOneSentence(const Outcome& outcome, int exitCode, const std::string& mention = "");

/// Options that reduce a fit to a fraction of a second.
std::vector<std::string> quickly(std::vector<std::string> arguments);

} // namespace innergs::test
