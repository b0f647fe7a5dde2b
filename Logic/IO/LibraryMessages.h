#pragma once

namespace innergs {

/// For a program that owns its standard error: from now on, drops what libraries print there while they read
/// or write an image, since an Error reports it.
void dropLibraryMessages();

/// While one lives, in any thread, standard error is discarded; does nothing without dropLibraryMessages().
class MuteStandardError {
public:
  MuteStandardError();
  ~MuteStandardError();
  MuteStandardError(const MuteStandardError&) = delete;
  MuteStandardError& operator=(const MuteStandardError&) = delete;

private:
  bool muted_;
};

} // namespace innergs
