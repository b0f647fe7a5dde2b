#include "IO/ClassicStreams.h"

#include <locale>
#include <mutex>

namespace innergs {

namespace {

std::mutex streamsMutex;
int classicStreams = 0; // number of live instances
std::locale hostsLocale;

} // namespace

ClassicStreams::ClassicStreams() {
  const std::lock_guard lock(streamsMutex);
  if (classicStreams++ > 0) return;
  hostsLocale = std::locale();
  if (hostsLocale != std::locale::classic()) // unnamed, so that the C library's locale is kept
    std::locale::global(std::locale(std::locale::classic(), new std::numpunct<char>));
}

ClassicStreams::~ClassicStreams() {
  const std::lock_guard lock(streamsMutex);
  if (--classicStreams == 0 && hostsLocale != std::locale::classic()) std::locale::global(hostsLocale);
}

} // namespace innergs
