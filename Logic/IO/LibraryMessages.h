#pragma once

namespace innergs {

/// For a program that owns its standard error: from now on, what libraries print there while they read or
/// write an image is dropped, since an Error says it.
void dropLibraryMessages();

/// While one lives, in any thread, standard error leads nowhere; without dropLibraryMessages() it does
/// nothing.
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
