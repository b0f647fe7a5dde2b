#pragma once

namespace innergs {

/// How the error e of one sample counts: |e|, ½e², or ½e² up to a delta and linear beyond (Huber 1964).
enum class LossKind { L1, L2, Huber };

} // namespace innergs
