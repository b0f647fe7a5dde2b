#pragma once

namespace innergs {

/// While one lives, in any thread, new C++ streams write a decimal point; MetaIO's streams follow the
/// program's global locale.
class ClassicStreams {
public:
  ClassicStreams();
  ~ClassicStreams();
  ClassicStreams(const ClassicStreams&) = delete;
  ClassicStreams& operator=(const ClassicStreams&) = delete;
};

} // namespace innergs
