#pragma once
#include "Core/Job/Progress.h"

#include <QString>

#include <cstdint>

/// Formats numbers for display.
namespace innergs::ui {

/// "a few seconds", "about 40 seconds", "about a minute", "about 5 minutes", "about 1 hour 20 minutes".
QString roughDuration(double seconds);
/// "8.3 s", "1 min 23 s", "1 h 05 min".
QString exactDuration(double seconds);
/// "850 kB", "64 MB", "1.6 GB".
QString memorySize(std::int64_t bytes);
/// "1,045,528", with the locale's group separator.
QString countText(std::int64_t count);
/// "41,000 Gaussians".
QString gaussiansText(std::int64_t count);
/// "Showing 20,000 of 1,045,528 Gaussians".
QString shownGaussiansText(std::int64_t shown, std::int64_t all);
/// The display name of an evaluation method: "InnerGS" for "gaussians", "Lanczos interpolation" for
/// "lanczos".
QString methodText(const QString& method);
/// phaseName(), translated.
QString phaseText(Phase phase);
/// At most three significant digits: "0.9", "4", "1.25".
QString lengthText(double mm);
/// The text, with a full stop at the end.
QString sentence(const QString& text);

} // namespace innergs::ui
