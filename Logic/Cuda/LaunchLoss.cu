#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(PointLosses);
INNERGS_LAUNCH(SumLosses);
INNERGS_LAUNCH(SsimTerms);
INNERGS_LAUNCH(SsimGradient);
