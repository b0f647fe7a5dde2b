#include "Fixtures.h"

#include "../Core/Motion/MovingPhantom.h"

#include "Core/Features/FeatureTraining.h"
#include "Core/Motion/DynamicFeatures.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/MotionField.h"
#include "Core/Render/Render.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSDynamicReconstruct.h"
#include "vtkInnerGSInterpolateTime.h"
#include "vtkInnerGSMotionField.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSResample.h"
#include "vtkInnerGSSegment.h"

#include <vtkDoubleArray.h>
#include <vtkInformation.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <gtest/gtest.h>

#include <limits>

namespace innergs::testing {
namespace {

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkSmartPointer<vtkInnerGSDynamicReconstruct> filterOf(const TimeSeries& series, int kind) {
  auto filter = vtkSmartPointer<vtkInnerGSDynamicReconstruct>::New();
  for (std::int64_t f = 0; f < series.size(); ++f) {
    filter->AddInputData(plainImage({series.geometry, series.frames[f]}));
    filter->SetFrameTime(static_cast<int>(f), series.times[f]);
  }
  filter->SetIJKToRASMatrix(rasMatrix(series.geometry));
  filter->SetKind(kind);
  filter->SetNumberOfGaussians(400);
  filter->SetNumberOfThreads(2);
  return filter;
}

/// Fitted once for all tests: a phantom that swings for 3 s.
struct Fitted {
  TimeSeries series = movingPhantom(evenTimes(7));
  vtkNew<vtkInnerGSDynamicModel> model;
  int events = 0;
  std::string device;
  Fitted() {
    const auto filter = filterOf(series, vtkInnerGSDynamicReconstruct::Motion);
    vtkNew<vtkCallbackCommand> count;
    count->SetClientData(&events);
    count->SetCallback([](vtkObject*, unsigned long, void* n, void*) { ++*static_cast<int*>(n); });
    filter->AddObserver(vtkCommand::ProgressEvent, count);
    filter->SetSetting("device", "cpu");
    filter->Update();
    device = filter->GetUsedDevice() + ": " + filter->GetDeviceNote();
    model->ShallowCopy(filter->GetOutput());
  }
};
Fitted& fitted() {
  static Fitted once;
  return once;
}

TEST(Dynamic, CopiesShareSegments) {
  FeatureModel features;
  features.names = {"background", "lunate"};
  vtkNew<vtkInnerGSDynamicModel> model, shallow, deep;
  model->SetField(fitted().model->GetField(), std::make_shared<const FeatureModel>(features));
  shallow->ShallowCopy(model);
  deep->DeepCopy(model);
  for (vtkInnerGSDynamicModel* copy : {shallow.Get(), deep.Get()}) {
    EXPECT_EQ(copy->GetFeatures(), model->GetFeatures());
    EXPECT_EQ(copy->GetNumberOfSegments(), 1);
    EXPECT_EQ(copy->GetSegmentName(0), "lunate");
    EXPECT_EQ(copy->GetSegmentName(1), "");
    copy->SetField(copy->GetField()); // a new fit knows none
    EXPECT_EQ(copy->GetNumberOfSegments(), 0);
  }
}

TEST(Dynamic, ReconstructsAsTheJobDoes) {
  vtkInnerGSDynamicModel* model = fitted().model;
  ASSERT_FALSE(model->IsEmpty());
  EXPECT_GT(fitted().events, 5);
  EXPECT_EQ(fitted().device.find("cpu: "), 0u) << fitted().device;
  EXPECT_EQ(model->GetKindName(), "motion");
  EXPECT_EQ(model->GetNumberOfFrames(), 7);
  EXPECT_EQ(model->GetFrameTime(2), 1.0);
  EXPECT_TRUE(std::isnan(model->GetFrameTime(7)));
  Settings settings;
  settings.kind = DynamicKind::Motion;
  settings.gaussians = 400;
  settings.threads = 1;
  const DynamicResult result = DynamicJob(fitted().series, settings).run();
  EXPECT_EQ(result.field->nodes, model->GetField()->nodes);
  EXPECT_EQ(result.field->ownPath, model->GetField()->ownPath);
}

TEST(Dynamic, TimeComesFromThePipeline) {
  vtkNew<vtkInnerGSInterpolateTime> at;
  at->SetDynamicModel(fitted().model);
  vtkNew<vtkInnerGSResample> volume;
  volume->SetInputConnection(at->GetOutputPort());
  volume->SetReferenceGrid(rasMatrix(fitted().series.geometry), 24, 22, 7);
  vtkNew<vtkInnerGSPlaneQuery> plane;
  plane->SetInputConnection(at->GetOutputPort());
  plane->SetDimensions(20, 16);
  plane->SetSpacing(1, 1);
  plane->UpdateInformation();
  vtkInformation* told = plane->GetOutputInformation(0);
  ASSERT_TRUE(told->Has(Pipeline::TIME_STEPS()));
  EXPECT_EQ(told->Length(Pipeline::TIME_STEPS()), 7);
  EXPECT_EQ(told->Get(Pipeline::TIME_RANGE())[1], 3.0);
  std::vector<float> before;
  for (const double time : {0.75, 2.1, 0.75}) {
    volume->UpdateTimeStep(time);
    EXPECT_EQ(at->GetOutputTime(), time);
    const Volume expected = render(fieldAt(*fitted().model->GetField(), time), fitted().series.geometry);
    const std::vector<float> values = valuesOf(volume->GetOutput());
    ASSERT_EQ(values.size(), expected.voxels.size());
    for (std::size_t v = 0; v < values.size(); ++v)
      ASSERT_EQ(values[v], expected.voxels[v]);
    plane->UpdateTimeStep(time);
    const std::vector<float> pixels = valuesOf(plane->GetOutput());
    ASSERT_EQ(pixels.size(), 320u);
    EXPECT_NE(pixels, before);
    before = pixels;
  }
  // Outside the frames' times: theirs. Without a request: Time.
  volume->UpdateTimeStep(99);
  EXPECT_EQ(at->GetOutputTime(), 3.0);
  vtkNew<vtkInnerGSInterpolateTime> alone;
  alone->SetDynamicModel(fitted().model);
  alone->SetTime(1.3);
  alone->Update();
  EXPECT_EQ(alone->GetOutputTime(), 1.3);
  EXPECT_EQ(alone->GetOutput()->GetNumberOfGaussians(), 400);
}

TEST(Dynamic, SegmentsAreFoundAtAnyTime) {
  const auto field = fitted().model->GetField();
  const GridGeometry& geometry = fitted().series.geometry;
  const double learned = 0.5;
  const Labelmap given = movingLabels(geometry, learned);
  FeatureModel features =
      trainFeatures(featureFieldAt(*field, learned), given, {{1, "lunate"}, {2, "capitate"}});
  features.time = learned;
  vtkNew<vtkInnerGSDynamicModel> model;
  model->SetField(field, std::make_shared<const FeatureModel>(features));

  vtkNew<vtkInnerGSInterpolateTime> at;
  at->SetDynamicModel(model);
  vtkNew<vtkInnerGSSegment> filter;
  filter->SetInputConnection(at->GetOutputPort());
  filter->SetReferenceGrid(rasMatrix(geometry), 24, 22, 7);
  filter->AddQuery("lunate");
  filter->AddQuery("capitate");
  const auto found = [&] {
    EXPECT_EQ(filter->GetErrorMessage(), "");
    Labelmap labels{geometry, {}, {}};
    vtkDataArray* scalars = filter->GetOutput()->GetPointData()->GetScalars();
    for (vtkIdType v = 0; scalars && v < scalars->GetNumberOfTuples(); ++v)
      labels.voxels.push_back(static_cast<std::uint16_t>(scalars->GetTuple1(v)));
    EXPECT_EQ(labels.voxels.size(), given.voxels.size());
    return labels;
  };
  for (const double time : {1.75, 2.6, 0.5}) {
    filter->UpdateTimeStep(time);
    const Labelmap labels = found(), truth = movingLabels(geometry, time);
    for (const std::uint16_t label : {std::uint16_t{1}, std::uint16_t{2}}) {
      EXPECT_GT(dice(labels, truth, label), 0.9) << "time " << time << " label " << label;
      if (time != learned) {
        EXPECT_GT(dice(labels, truth, label), dice(given, truth, label)) << "time " << time;
      }
    }
  }

  // The model at a time knows them by itself, and copies of it do, but is not saved with them.
  const auto posed = vtkSmartPointer<vtkInnerGSModel>::Take(model->NewModelAt(1.75));
  EXPECT_EQ(posed->GetSegmentName(1), "capitate");
  EXPECT_EQ(posed->GetFeatures(), nullptr);
  vtkNew<vtkInnerGSModel> copy;
  copy->DeepCopy(posed);
  filter->UpdateTimeStep(1.75);
  const Labelmap before = found();
  filter->SetModel(copy);
  filter->Update();
  EXPECT_EQ(found().voxels, before.voxels);
  copy->SetCoreModel(posed->GetCoreModel());
  EXPECT_EQ(copy->GetNumberOfSegments(), 0);
}

TEST(Dynamic, MotionIsInRas) {
  vtkNew<vtkInnerGSMotionField> motion;
  motion->SetDynamicModel(fitted().model);
  motion->UseMiddleFrameOff();
  motion->SetFrom(0.5);
  motion->UpdateTimeStep(2);
  vtkImageData* image = motion->GetOutput();
  ASSERT_EQ(image->GetNumberOfScalarComponents(), 3);
  const std::vector<float> lps = motionField(*fitted().model->GetField(), 0.5, 2, fitted().series.geometry);
  const auto* ras = static_cast<const float*>(image->GetScalarPointer());
  double moves = 0;
  for (std::size_t n = 0; n < lps.size(); ++n) {
    ASSERT_EQ(ras[n], n % 3 == 2 ? lps[n] : -lps[n]);
    moves = std::max(moves, std::abs(static_cast<double>(lps[n])));
  }
  EXPECT_GT(moves, 0.3);
  EXPECT_TRUE(closeTo(motion->GetOutputIJKToRASMatrix(), rasMatrix(fitted().series.geometry)));
}

TEST(Dynamic, WhatIsWrongIsOneSentence) {
  vtkNew<vtkCallbackCommand> quiet;
  const auto failure = [&](vtkInnerGSAlgorithm* filter) {
    filter->AddObserver(vtkCommand::ErrorEvent, quiet);
    filter->Update();
    return filter->GetErrorMessage();
  };
  const TimeSeries series = movingPhantom(evenTimes(3));
  const auto with = [&](const auto& change) {
    const auto filter = filterOf(series, vtkInnerGSDynamicReconstruct::Motion);
    change(filter.Get());
    return failure(filter);
  };
  const auto missing = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(with([&](auto* f) { f->SetFrameTime(1, missing); }).find("not finite"), std::string::npos);
  EXPECT_NE(with([&](auto* f) { f->SetFrameTime(1, 0); }).find("do not increase"), std::string::npos);
  EXPECT_NE(with([&](auto* f) { f->ClearInputs(); }).find("no frames"), std::string::npos);
  EXPECT_NE(with([&](auto* f) {
              f->SetFrameTime(3, 9);
              f->AddInputData(plainImage(volumeOf(grid(3, 3, 3), [](int, int, int) { return 1.f; })));
            }).find("another grid"),
            std::string::npos);
  EXPECT_NE(with([&](auto* f) {
              f->ClearInputs();
              f->AddInputData(plainImage({series.geometry, series.frames[0]}));
              f->SetFrameTime(0, 0);
            }).find("single frame"),
            std::string::npos);
  vtkNew<vtkInnerGSInterpolateTime> at;
  EXPECT_NE(failure(at).find("no model of a dynamic scan"), std::string::npos);
}

/// Slices at their own times give what the job gives of them, and another model than frames at one time.
TEST(Dynamic, SlicesHaveTimesOfTheirOwn) {
  TimeSeries series = movingPhantom(evenTimes(8));
  const auto slices = static_cast<int>(series.geometry.size[2]);
  vtkNew<vtkDoubleArray> times;
  for (int k = 0; k < slices; ++k)
    times->InsertNextValue(0.5 * ((3 * k) % slices) / slices);
  const auto changesOf = [&](const auto& change) {
    const auto filter = filterOf(series, vtkInnerGSDynamicReconstruct::Intensity);
    filter->SetSetting("gaussians", "");
    change(filter.Get());
    filter->Update();
    return filter->GetOutput()->IsEmpty() ? std::vector<float>() : filter->GetOutput()->GetField()->changes;
  };
  const std::vector<float> timed = changesOf([&](auto* f) { f->SetSliceTimes(times); });
  ASSERT_FALSE(timed.empty());
  EXPECT_NE(timed, changesOf([](auto*) {}));
  EXPECT_EQ(changesOf([](auto*) {}), changesOf([&](auto* f) {
              f->SetSliceTimes(times);
              f->SetSetting("sliceTiming", "false");
            }));
  Settings settings;
  settings.kind = DynamicKind::Intensity;
  settings.threads = 1;
  series.sliceTiming = {2, {times->GetPointer(0), times->GetPointer(0) + slices}};
  EXPECT_EQ(timed, DynamicJob(series, settings).run().field->changes);

  const auto filter = filterOf(series, vtkInnerGSDynamicReconstruct::Intensity);
  vtkNew<vtkCallbackCommand> quiet;
  filter->AddObserver(vtkCommand::ErrorEvent, quiet);
  filter->SetSliceTimes(times);
  filter->SetSliceAxis(0);
  filter->Update();
  EXPECT_NE(filter->GetErrorMessage().find("not one per slice"), std::string::npos);
  times->SetValue(1, 500); // ms
  filter->SetSliceAxis(2);
  times->Modified();
  filter->Modified();
  filter->Update();
  EXPECT_NE(filter->GetErrorMessage().find("in seconds"), std::string::npos);
}

TEST(Dynamic, StopsWhenAsked) {
  const auto filter = filterOf(movingPhantom(evenTimes(9)), vtkInnerGSDynamicReconstruct::Motion);
  vtkNew<vtkCallbackCommand> stop;
  stop->SetCallback([](vtkObject* caller, unsigned long, void*, void*) {
    static_cast<vtkInnerGSDynamicReconstruct*>(caller)->AbortExecuteOn();
  });
  filter->AddObserver(vtkCommand::ProgressEvent, stop);
  filter->Update();
  EXPECT_TRUE(filter->GetAborted());
  EXPECT_TRUE(filter->GetErrorMessage().empty());
  EXPECT_TRUE(filter->GetOutput()->IsEmpty());
}

} // namespace
} // namespace innergs::testing
