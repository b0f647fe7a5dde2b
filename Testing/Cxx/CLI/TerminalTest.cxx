#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "IO/VolumeIO.h"

#include <cstdlib>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace innergs::test {
namespace {

using TerminalTest = CommandTest;

// On a terminal, the progress is one line that redraws itself and disappears at the end.
TEST_F(TerminalTest, ProgressBar) {
  writeVolume(phantom({40, 40, 40}), path("scan.nii"));
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0)
    GTEST_SKIP() << "no pseudo-terminals here";
  const std::string side = ptsname(terminal), command = INNERGS_COMMAND, scan = path("scan.nii"),
                    output = path("v.nii");
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(side.c_str(), O_RDWR | O_NOCTTY);
    dup2(file, STDERR_FILENO);
    execl(command.c_str(), command.c_str(), "reconstruct", scan.c_str(), "-o", output.c_str(), "--preset",
          "fast", nullptr);
    _exit(127);
  }
  std::string shown;
  const int keepOpen = open(side.c_str(), O_RDWR | O_NOCTTY); // no hang-up between two writers
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  int status = 0;
  for (bool running = true; running;) {
    running = waitpid(child, &status, WNOHANG) == 0;
    char buffer[4096];
    for (ssize_t n; (n = read(terminal, buffer, sizeof(buffer))) > 0;)
      shown.append(buffer, n);
    usleep(10000);
  }
  close(keepOpen);
  close(terminal);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << shown;
  EXPECT_NE(shown.find("\rFitting"), std::string::npos) << shown;
  EXPECT_NE(shown.find("[#"), std::string::npos) << shown;
  const auto lastBar = shown.rfind("[#"), summary = shown.find("Wrote ");
  ASSERT_NE(summary, std::string::npos) << shown;
  EXPECT_LT(lastBar, summary);
  for (std::size_t begin = shown.find('\r'), end; begin < lastBar; begin = end) {
    end = std::min(shown.find('\r', begin + 1), shown.size());
    const std::string bar = shown.substr(begin, end - begin);
    if (shown.compare(end, 2, "\r\n") == 0) continue; // a sentence, which the terminal wraps
    EXPECT_LT(bar.size(), 82u) << "too long for a terminal of 80 columns: " << bar;
  }
}

} // namespace
} // namespace innergs::test
