#include "Core/Fit/CpuFitDevice.h"
#include "Core/Fit/Trainer.h"
#include "Core/Render/Kernels.h"
#include "FakeDevice.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A fit that uses everything a device must support.
class DeviceTrainer : public FakeDevice {
protected:
  void SetUp() override {
    FakeDevice::SetUp();
    for (int i = 0; i < 200; ++i) {
      Gaussian g{};
      g.mean[0] = static_cast<float>(2 + i % 6 * 3.5), g.mean[1] = static_cast<float>(2 + i / 6 % 6 * 3.2);
      g.mean[2] = static_cast<float>(2 + i / 36 * 3);
      g.quaternion[0] = 1;
      std::fill_n(g.logScale, 3, 0.5f);
      g.intensity = 0.4f;
      field.gaussians.push_back(g);
    }
    field.cutoff = plan.cutoff;
    plan.iterations = 40;
    plan.coarseIterations = 4;
    plan.rates = {0.2, 0.09, 0.09, 0.15, 0.03, 0};
    plan.bounds = {std::log(0.3), std::log(30.0)};
    plan.schedule = Schedule::Plateau;
    plan.plateau = {2, 0.7, 0.01, 1e-2};
    plan.relocateEvery = 5;
    plan.relocateShare = 0.05;
    plan.densify.every = 7;
    plan.densify.thresholds = {0.3, 4, 0.01, 2};
    plan.densify.limit = 280;
    plan.densify.minLogScale = plan.bounds.minLogScale;
  }

  std::vector<Observation> observations() const {
    return observe(pointStack(phantom(grid(24, 22, 20, {1, 1, 1}))), {}, {200, 0}, false);
  }

  Trainer onCpu() { return Trainer(field, observations(), plan, kernelSet("scalar"), pool); }
  Trainer onDevice() {
    FitRequest request = fitRequest(observations(), plan, field, pool.stopToken());
    DeviceChoice choice("cuda:0");
    std::unique_ptr<FitDevice> device = choice.makeFit(request);
    EXPECT_TRUE(device);
    return Trainer(field, std::move(request), plan, kernelSet("scalar"), pool, std::move(device));
  }

  static void same(Trainer& a, Trainer& b) {
    EXPECT_TRUE(sameField(a.field(), b.field()));
    EXPECT_EQ(a.adam().moment1, b.adam().moment1);
    EXPECT_EQ(a.adam().moment2, b.adam().moment2);
    EXPECT_EQ(a.gradients(), b.gradients());
    EXPECT_EQ(a.iteration(), b.iteration());
    EXPECT_EQ(a.gaussians(), b.gaussians());
    EXPECT_EQ(a.losses(), b.losses());
    EXPECT_EQ(a.densified().pruned, b.densified().pruned);
    EXPECT_EQ(a.densified().split, b.densified().split);
    EXPECT_EQ(a.densified().cloned, b.densified().cloned);
    EXPECT_EQ(a.gaussians(), a.field().size());
  }

  ThreadPool pool{2};
  GaussianField field;
  FitPlan plan;
};

} // namespace

TEST_F(DeviceTrainer, GoesTheSameWayOnAnyDevice) {
  Trainer cpu = onCpu(), device = onDevice();
  for (int iteration = 0; cpu.step(); ++iteration) {
    ASSERT_TRUE(device.step());
    EXPECT_EQ(cpu.loss(), device.loss());
    EXPECT_EQ(cpu.gaussians(), device.gaussians());
    if (iteration % 9 == 0) same(cpu, device);
  }
  EXPECT_FALSE(device.step());
  same(cpu, device);
  EXPECT_EQ(cpu.evaluate(cpu.field()).loss, device.evaluate(cpu.field()).loss);
  EXPECT_EQ(device.failure(), "");
  EXPECT_GT(cpu.densified().split + cpu.densified().cloned + cpu.densified().pruned, 0);
  EXPECT_NE(cpu.gaussians(), 200);
}

TEST_F(DeviceTrainer, GoesOnOnTheCpuAsIfNothingHadHappened) {
  Trainer cpu = onCpu();
  while (cpu.step()) {
  }
  for (const char* how :
       {"upload", "iteration:1", "iteration:3", "iteration:12", "iteration:40", "reshape", "evaluate"}) {
    SCOPED_TRACE(how);
    fails(how);
    Trainer device = onDevice();
    int iterations = 0;
    while (device.step())
      ++iterations;
    EXPECT_EQ(iterations, 40);
    EXPECT_EQ(cpu.evaluate(field).loss, device.evaluate(field).loss);
    same(cpu, device);
    EXPECT_EQ(device.failure(), "The device has no memory left.");
  }
}

TEST_F(DeviceTrainer, GoesBackToTheLastStateItHasWhenTheDeviceIsLost) {
  Trainer cpu = onCpu();
  while (cpu.step()) {
  }
  for (const int fetch : {0, 3, 11, 14}) { // iterations after which the state is fetched
    SCOPED_TRACE(fetch);
    fails("lost:17");
    Trainer device = onDevice();
    int iterations = 0;
    while (device.step())
      if (++iterations == fetch) {
        EXPECT_GT(device.field().size(), 0);
      }
    EXPECT_EQ(iterations, 17 + 40 - fetch); // the 17th is the one that failed
    same(cpu, device);
    EXPECT_EQ(device.failure(), "The device fell off the bus.");
  }
}

TEST_F(DeviceTrainer, RepeatsWhatCannotBeFetched) {
  Trainer cpu = onCpu();
  while (cpu.step()) {
  }
  fails("download");
  Trainer device = onDevice();
  while (device.step()) {
  }
  same(cpu, device);
  Trainer looked = onDevice();
  for (int i = 0; i < 5; ++i)
    looked.step();
  EXPECT_TRUE(sameField(looked.field(), field)) << "all that is left";
  EXPECT_EQ(looked.iteration(), 0);
  EXPECT_TRUE(looked.losses().empty());
  while (looked.step()) {
  }
  same(cpu, looked);
}

TEST_F(DeviceTrainer, RestartsAndRestoresOnAnyDevice) {
  Trainer cpu = onCpu(), device = onDevice();
  for (Trainer* trainer : {&cpu, &device}) {
    for (int i = 0; i < 6; ++i)
      trainer->step();
    trainer->restart(field);
    for (int i = 0; i < 9; ++i)
      trainer->step();
  }
  same(cpu, device);
  const GaussianField reached = device.field();
  const OptimizerState state = device.optimizer();
  for (Trainer* trainer : {&cpu, &device}) { // each continues from the other's state
    trainer->restart(reached);
    trainer->restore(state, 9);
    while (trainer->step()) {
    }
  }
  EXPECT_TRUE(sameField(cpu.field(), device.field()));
  Trainer whole = onCpu();
  while (whole.step()) {
  }
  EXPECT_TRUE(sameField(whole.field(), device.field()));
}

TEST_F(DeviceTrainer, StoppedKeepsItsState) {
  Trainer device = onDevice(), cpu = onCpu();
  std::stop_source stop;
  pool.setStop(stop.get_token());
  Trainer stopped = onDevice();
  for (int i = 0; i < 10; ++i) {
    stopped.step();
    cpu.step();
  }
  stop.request_stop();
  EXPECT_THROW(stopped.step(), Error);
  EXPECT_EQ(stopped.failure(), "");
  same(cpu, stopped);
}
