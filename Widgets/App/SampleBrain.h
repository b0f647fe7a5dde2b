#pragma once
#include "Widgets/App/DataItems.h"

namespace innergs::app {

/// The T1 head that the sample is made of: the file chosen last, one beside the program, in the system's
/// folders of data, or MRIcron's; "" where there is none.
QString sampleBrain();
/// Taken first from now on.
void rememberSampleBrain(const QString& file);
/// What to choose where there is none, a sentence.
QString whatIsTheSampleBrain();
/// A scan with axial slices of about 5 mm, simulated from the head, and the head itself to compare with. For
/// worker threads; throws Error with one sentence.
std::vector<VolumeItem> makeSample(const QString& brain);

} // namespace innergs::app
