#pragma once
#include "Widgets/App/DataItems.h"

namespace innergs::app {

/// The T1 head that the sample is made from: the file chosen last, one beside the program, in the system's
/// data folders, or MRIcron's; "" if there is none.
QString sampleBrain();
/// Uses this file first from now on.
void rememberSampleBrain(const QString& file);
/// A sentence on what to choose if there is none.
QString whatIsTheSampleBrain();
/// A scan with axial slices of about 5 mm, simulated from the head, and the head itself to compare with. For
/// worker threads; throws Error with one sentence.
std::vector<VolumeItem> makeSample(const QString& brain);

} // namespace innergs::app
