#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(CountPairs<TileReach>);
INNERGS_LAUNCH(EmitPairs<TileReach>);
INNERGS_LAUNCH(Composite);
INNERGS_LAUNCH(CompositeBackward);
INNERGS_LAUNCH(SumSlots);
