#pragma once

namespace innergs {

/// How one sample's error e counts: |e|, ½e², or ½e² up to a delta and |e| beyond (Huber 1964).
enum class LossKind { L1, L2, Huber };

} // namespace innergs
