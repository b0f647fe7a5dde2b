#include "Cuda/Launch.cuh"

using namespace innergs::cuda;

INNERGS_LAUNCH(RelocationKeys);
INNERGS_LAUNCH(MarkParents);
INNERGS_LAUNCH(CountReplaced);
INNERGS_LAUNCH(TakeReplaced);
INNERGS_LAUNCH(Relocate);
INNERGS_LAUNCH(DensifyMarks);
INNERGS_LAUNCH(TakeKept);
INNERGS_LAUNCH(Densify);
INNERGS_LAUNCH(BoxMeans);
INNERGS_LAUNCH(BoxBoxes);
INNERGS_LAUNCH(MortonKeys);
INNERGS_LAUNCH(TakeIds);
INNERGS_LAUNCH(TakeRecords);
