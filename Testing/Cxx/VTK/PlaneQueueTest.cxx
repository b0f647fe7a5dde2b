#include "PlaneQueue.h"
#include "Fixtures.h"

#include "vtkInnerGSPlaneQuery.h"

#include <future>
#include <mutex>
#include <thread>

using namespace innergs;
using namespace innergs::testing;

namespace {

PlaneRequest planeAt(const std::shared_ptr<const Model>& model, int side = 8) {
  PlaneRequest request;
  request.model = model;
  request.planeToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  request.columns = side;
  request.rows = side + 1;
  request.spacing = 0.5;
  return request;
}

struct PlaneQueueTest : ::testing::Test {
  std::shared_ptr<const Model> model = [] {
    auto made = std::make_shared<Model>();
    made->field = randomSmallField();
    return made;
  }();
  std::mutex mutex;
  std::vector<int> answered; // keys, in order

  PlaneQueue::Answer note(int key) {
    return [this, key](const QueriedPlane&) {
      std::lock_guard lock(mutex);
      answered.push_back(key);
    };
  }
  /// Waits until everything requested so far with lower keys has been answered.
  static void waitFor(PlaneQueue& queue, const std::shared_ptr<const Model>& model) {
    const auto last = std::make_shared<std::promise<void>>();
    queue.request(1000, planeAt(model), [last](const QueriedPlane&) { last->set_value(); });
    last->get_future().wait();
  }
};

TEST_F(PlaneQueueTest, AnswersWhatTheFilterGives) {
  vtkNew<vtkInnerGSModel> data;
  data->SetCoreModel(model);
  vtkNew<vtkInnerGSPlaneQuery> filter;
  filter->SetModel(data);
  filter->CentredOff();
  filter->GeometryInImageOff();
  filter->SetDimensions(8, 9);
  filter->SetSpacing(0.5, 0.5);
  const auto expected = filter->Query();
  for (const bool background : {false, true}) {
    std::promise<QueriedPlane> answer;
    PlaneQueue queue(background);
    queue.request(0, planeAt(model), [&](const QueriedPlane& plane) { answer.set_value(plane); });
    const QueriedPlane plane = answer.get_future().get();
    EXPECT_EQ(plane.error, "");
    ASSERT_TRUE(plane.image);
    EXPECT_EQ(valuesOf(plane.image), valuesOf(expected));
    EXPECT_TRUE(closeTo(plane.ijkToRAS, filter->GetOutputIJKToRASMatrix()));
    EXPECT_FALSE(plane.deviation);
  }
}

TEST_F(PlaneQueueTest, LowerKeysGoFirstAndTheLatestOfAKeyCounts) {
  std::promise<void> begun, released;
  PlaneQueue queue;
  queue.request(7, planeAt(model), [&](const QueriedPlane&) {
    begun.set_value();
    released.get_future().wait();
  });
  begun.get_future().wait();
  queue.request(9, planeAt(model), note(9));
  queue.request(5, planeAt(model), note(-5)); // replaced below
  queue.request(3, planeAt(model), note(3));
  queue.request(2, planeAt(model), note(2)); // dropped
  queue.request(5, planeAt(model), note(5));
  queue.drop(2);
  released.set_value();
  waitFor(queue, model);
  EXPECT_EQ(answered, (std::vector<int>{3, 5, 9}));
}

TEST_F(PlaneQueueTest, ARestingRequestLetsOthersPassAndEndsWithTheQueue) {
  {
    PlaneQueue queue;
    queue.request(0, planeAt(model), note(0), std::chrono::hours(1));
    queue.request(1, planeAt(model), note(1));
    waitFor(queue, model);
    const auto rested = std::make_shared<std::promise<void>>();
    queue.request(
        2, planeAt(model), [rested](const QueriedPlane&) { rested->set_value(); },
        std::chrono::milliseconds(1));
    rested->get_future().wait();
  }
  EXPECT_EQ(answered, std::vector<int>{1});
}

TEST_F(PlaneQueueTest, AnInterruptedQueryIsCarriedOutLater) {
  std::promise<QueriedPlane> answer;
  auto future = answer.get_future();
  PlaneQueue queue;
  queue.request(4, planeAt(model, 400), [&](const QueriedPlane& plane) { answer.set_value(plane); });
  for (int i = 0; i < 100; ++i) {
    queue.interrupt(4);
    queue.interrupt(5); // another's: no effect
    std::this_thread::yield();
  }
  const QueriedPlane plane = future.get();
  EXPECT_EQ(plane.error, "");
  ASSERT_TRUE(plane.image);
  EXPECT_EQ(plane.image->GetNumberOfPoints(), 400 * 401);
}

TEST_F(PlaneQueueTest, ErrorsAreSentencesAndTheQueueGoesOn) {
  PlaneRequest bad = planeAt(model);
  bad.spacing = 0;
  std::promise<QueriedPlane> answer;
  PlaneQueue queue;
  queue.request(0, bad, [&](const QueriedPlane& plane) { answer.set_value(plane); });
  const QueriedPlane plane = answer.get_future().get();
  EXPECT_FALSE(plane.image);
  EXPECT_TRUE(plane.error.ends_with(".")) << plane.error;
  queue.request(1, planeAt(model), note(1));
  waitFor(queue, model);
  EXPECT_EQ(answered, std::vector<int>{1});
}

} // namespace
