#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(Project);
INNERGS_LAUNCH(CountPairs<BrickReach>);
INNERGS_LAUNCH(EmitPairs<BrickReach>);
INNERGS_LAUNCH(FindStarts);
INNERGS_LAUNCH(Accumulate);
INNERGS_LAUNCH(Gather);
INNERGS_LAUNCH(GatherLarge);
INNERGS_LAUNCH(Chain);
INNERGS_LAUNCH(Update);
