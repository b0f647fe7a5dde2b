#pragma once
#include "IO/LibraryMessages.h"

#include <itkObject.h>

namespace innergs {

/// While it lives, silences ITK's warnings on standard error; errors become an Error.
class QuietItk {
public:
  QuietItk() : before_(itk::Object::GetGlobalWarningDisplay()) {
    itk::Object::SetGlobalWarningDisplay(false);
  }
  ~QuietItk() { itk::Object::SetGlobalWarningDisplay(before_); }
  QuietItk(const QuietItk&) = delete;
  QuietItk& operator=(const QuietItk&) = delete;

private:
  bool before_;
  MuteStandardError mute_; // niftilib, MetaIO and HDF5 cannot be silenced otherwise
};

} // namespace innergs
