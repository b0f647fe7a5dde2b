#pragma once
#include "CLI/Picture.h"
#include "Evaluation/ExperimentAblation.h"
#include "Evaluation/ExperimentContour.h"
#include "Evaluation/ExperimentPrediction.h"
#include "Evaluation/ExperimentStatic.h"

namespace innergs::cli {

/// The example Gaussian on its slices, with the contours of the 3D Gaussian (thick) and of the splat (thin).
Picture contourPicture(const ContourResult& result);

/// A held-out axial slice: the truth, and every blending with its error, in radiological orientation.
Picture staticPicture(const StaticExperiment& experiment, const std::string& title);

/// Training PSNR over time, with dots for the PSNR on the held-out slices.
Picture ablationChart(const Ablation& ablation, const std::string& title);

/// A bar for the PSNR of every part, case by case.
Picture predictionChart(const PredictionAblation& ablation);

} // namespace innergs::cli
