#pragma once
#include "Cuda/Kernels/Accumulate.h"
#include "Cuda/Kernels/Bin.h"
#include "Cuda/Kernels/Composite.h"
#include "Cuda/Kernels/CompositeBackward.h"
#include "Cuda/Kernels/Features.h"
#include "Cuda/Kernels/Gather.h"
#include "Cuda/Kernels/Loss.h"
#include "Cuda/Kernels/MortonOrder.h"
#include "Cuda/Kernels/Project.h"
#include "Cuda/Kernels/Query.h"
#include "Cuda/Kernels/Reshape.h"
#include "Cuda/Kernels/Ssim.h"
#include "Cuda/Kernels/Update.h"

namespace innergs::cuda {

template <class... Kernels>
struct KernelList {};

using AllKernels =
    KernelList<Project, CountPairs<BrickReach>, CountPairs<TileReach>, CountPairs<CellReach>,
               EmitPairs<BrickReach>, EmitPairs<TileReach>, EmitPairs<CellReach>, FindStarts, Accumulate,
               Gather, GatherLarge, Composite, CompositeBackward, SumSlots, PointLosses, SumLosses, SsimTerms,
               SsimGradient, Chain, Update, Finish, QueryPoints, RelocationKeys, MarkParents, CountReplaced,
               TakeReplaced, Relocate, DensifyMarks, TakeKept, Densify, BoxMeans, BoxBoxes, MortonKeys,
               TakeIds, TakeRecords, FeatureGradients, CodeGradients, SumCodeChunks, UpdateCodes,
               UpdateLatents>;

} // namespace innergs::cuda
