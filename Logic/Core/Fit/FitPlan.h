#pragma once
#include "Core/Fit/FitDevice.h"
#include "Core/Fit/Initialise.h"

namespace innergs {

/// All parameters of a fit: a function of preset and data (Plan.h), never of the machine.
struct FitPlan {
  InitialisationPlan start;
  bool linearIntensity = false;
  int iterations = 200;
  int coarseIterations = 0;       // the first ones use the data at half resolution
  int subsets = 1;                // of the observations: iterations use one of them in turn
  bool smoothAlongNormal = false; // see observe()
  LossKinds loss;
  LearningRates rates; // at the start
  Schedule schedule = Schedule::Exponential;
  double finalRate = 0.05; // the rates decay exponentially to this share
  PlateauRule plateau;
  double cutoff = 2.2; // Mahalanobis radius
  FieldBounds bounds;
  double beta1 = 0.8, beta2 = 0.95;
  int relocateEvery = 0;       // 0 = never
  double relocateShare = 0.02; // of the Gaussians, per relocation
  double relocateUntil = 0.6;  // share of the iterations during which it runs
  DensifyPlan densify;
  bool allAxes = false; // see Settings
  bool paperStopRule = false;
};

} // namespace innergs
