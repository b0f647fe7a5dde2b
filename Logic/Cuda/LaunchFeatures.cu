#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(FeatureGradients);
INNERGS_LAUNCH(CodeGradients);
INNERGS_LAUNCH(SumCodeChunks);
INNERGS_LAUNCH(UpdateCodes);
INNERGS_LAUNCH(UpdateLatents);
