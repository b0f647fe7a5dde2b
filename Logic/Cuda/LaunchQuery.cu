#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(CountPairs<CellReach>);
INNERGS_LAUNCH(EmitPairs<CellReach>);
INNERGS_LAUNCH(Finish);
INNERGS_LAUNCH(QueryPoints);
