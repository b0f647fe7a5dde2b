#pragma once
#include "MrmlFixture.h"

#include <chrono>
#include <thread>

using JobTest = MrmlFixture;
using Logic = vtkSlicerInnerGSLogic;
using Clock = std::chrono::steady_clock;

inline double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline vtkSlicerInnerGSJob* jobOf(void* callData) {
  return static_cast<vtkSlicerInnerGSJob*>(callData);
}
