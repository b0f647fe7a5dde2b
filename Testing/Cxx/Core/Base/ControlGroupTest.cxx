#include "Core/Base/ControlGroup.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>

using namespace innergs;
namespace fs = std::filesystem;

namespace {

/// The files of a made-up Linux system.
class FakeSystem : public ::testing::Test {
protected:
  FakeSystem()
      : root_(fs::temp_directory_path() / ("innergs-cgroup-" + std::to_string(std::random_device()()))) {}
  ~FakeSystem() override {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  void file(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text << "\n";
  }
  fs::path root_;
};

} // namespace

TEST_F(FakeSystem, WithoutLimitsSaysNothing) {
  EXPECT_EQ(controlGroupRoom(root_), std::nullopt);
  file("proc/self/cgroup", "0::/user.slice");
  file("sys/fs/cgroup/user.slice/memory.max", "max");
  file("sys/fs/cgroup/user.slice/memory.current", "500");
  EXPECT_EQ(controlGroupRoom(root_), std::nullopt);
}

TEST_F(FakeSystem, Version2TakesTheTightestOfTheNestedGroups) {
  file("proc/self/cgroup", "0::/batch.slice/job7/step0");
  file("sys/fs/cgroup/batch.slice/memory.max", "8000");
  file("sys/fs/cgroup/batch.slice/memory.current", "1000");
  file("sys/fs/cgroup/batch.slice/job7/memory.max", "4000");
  file("sys/fs/cgroup/batch.slice/job7/memory.current", "1500");
  file("sys/fs/cgroup/batch.slice/job7/memory.stat", "anon 700\ninactive_file 600\nactive_file 1");
  file("sys/fs/cgroup/batch.slice/job7/step0/memory.max", "max");
  file("sys/fs/cgroup/batch.slice/job7/step0/memory.current", "1500");
  EXPECT_EQ(controlGroupRoom(root_), 4000 - (1500 - 600));
}

TEST_F(FakeSystem, OfAContainerIsTheTopOne) {
  file("proc/self/cgroup", "0::/");
  file("sys/fs/cgroup/memory.max", "3000");
  file("sys/fs/cgroup/memory.current", "1000");
  EXPECT_EQ(controlGroupRoom(root_), 2000);
}

TEST_F(FakeSystem, Version1) {
  file("proc/self/cgroup", "5:cpu,cpuacct:/docker/ab\n4:memory:/docker/ab\n1:name=systemd:/docker/ab");
  file("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712"); // none
  file("sys/fs/cgroup/memory/memory.usage_in_bytes", "90000");
  file("sys/fs/cgroup/memory/docker/ab/memory.limit_in_bytes", "6000");
  file("sys/fs/cgroup/memory/docker/ab/memory.usage_in_bytes", "2500");
  file("sys/fs/cgroup/memory/docker/ab/memory.stat", "inactive_file 1\ntotal_inactive_file 500");
  EXPECT_EQ(controlGroupRoom(root_), 4000);
}

TEST_F(FakeSystem, FullGroupsLeaveNothing) {
  file("proc/self/cgroup", "0::/a");
  file("sys/fs/cgroup/a/memory.max", "1000");
  file("sys/fs/cgroup/a/memory.current", "1200");
  EXPECT_EQ(controlGroupRoom(root_), 0);
}
