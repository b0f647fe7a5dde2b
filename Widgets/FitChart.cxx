#include "Widgets/FitChart.h"

#include <QEvent>
#include <QVBoxLayout>
#include <QVTKOpenGLNativeWidget.h>

#include <vtkAxis.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <cmath>

namespace innergs::ui {
namespace {

constexpr int kDrawInterval = 250; // ms
constexpr vtkIdType kMostRows = 2000;
enum Column { Sweep, Fit, HeldOut, Loss, Columns };
constexpr const char* kNames[Columns] = {"sweep", "fit", "held-out", "loss"};

void setColour(vtkTextProperty* text, const QColor& colour) {
  text->SetColor(colour.redF(), colour.greenF(), colour.blueF());
}

} // namespace

FitChart::FitChart(QWidget* parent) : QWidget(parent) {
  for (const char* name : kNames) {
    vtkNew<vtkDoubleArray> column;
    column->SetName(name);
    table_->AddColumn(column);
  }
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  setMinimumHeight(9 * fontMetrics().lineSpacing());
  // Not when first shown: Qt 6 makes a shown window anew for its first OpenGL child, and the focus is lost.
  view_ = new QVTKOpenGLNativeWidget(this);
  view_->setFocusPolicy(Qt::NoFocus);
  view_->setAttribute(Qt::WA_TransparentForMouseEvents); // the wheel scrolls the panel
  layout->addWidget(view_);
  setAccessibleName(tr("PSNR and loss over the sweeps"));
  timer_.setSingleShot(true);
  timer_.setInterval(kDrawInterval);
  connect(&timer_, &QTimer::timeout, this, &FitChart::draw);
}

FitChart::~FitChart() = default;

void FitChart::clear() {
  table_->SetNumberOfRows(0);
  lastIteration_ = 0;
  draw();
}

void FitChart::add(const Progress& progress) {
  if (progress.iteration <= lastIteration_ || !(progress.loss > 0)) return;
  lastIteration_ = progress.iteration;
  if (table_->GetNumberOfRows() >= kMostRows)
    for (vtkIdType row = table_->GetNumberOfRows() - 2; row > 0; row -= 2)
      table_->RemoveRow(row);
  const double known[Columns] = {static_cast<double>(progress.iteration),
                                 progress.trainingPsnr > 0 ? progress.trainingPsnr : NAN,
                                 progress.heldOutPsnr > 0 ? progress.heldOutPsnr : NAN, progress.loss};
  const vtkIdType row = table_->InsertNextBlankRow();
  for (int c = 0; c < Columns; ++c)
    table_->SetValue(row, c, known[c]);
  if (!timer_.isActive()) timer_.start();
}

int FitChart::points() const {
  return static_cast<int>(table_->GetNumberOfRows());
}

void FitChart::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange || event->type() == QEvent::FontChange) colour();
  QWidget::changeEvent(event);
}

void FitChart::showEvent(QShowEvent* event) {
  make();
  QWidget::showEvent(event);
}

void FitChart::make() {
  if (chart_) return;
  context_ = vtkSmartPointer<vtkContextView>::New();
  context_->SetRenderWindow(view_->renderWindow());
  context_->SetInteractor(view_->interactor());
  chart_ = vtkSmartPointer<vtkChartXY>::New();
  context_->GetScene()->AddItem(chart_);
  chart_->SetShowLegend(false);
  for (const Column column : {Loss, Fit, HeldOut}) {
    vtkPlot* plot = chart_->AddPlot(vtkChart::LINE);
    plot->SetInputData(table_, kNames[Sweep], kNames[column]);
    chart_->SetPlotCorner(plot, column == Loss ? 1 : 0);
    plot->SetWidth(column == Loss ? 1.f : 2.f);
    if (column == HeldOut) plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
  }
  chart_->GetAxis(vtkAxis::LEFT)->SetTitle("dB");
  chart_->GetAxis(vtkAxis::BOTTOM)->SetTitle(tr("Sweep").toStdString());
  chart_->GetAxis(vtkAxis::RIGHT)->SetTitle(tr("Loss").toStdString()); // its number stands beside the chart
  chart_->GetAxis(vtkAxis::RIGHT)->SetLabelsVisible(false);
  chart_->GetAxis(vtkAxis::RIGHT)->SetTicksVisible(false);
  chart_->GetAxis(vtkAxis::RIGHT)->SetLogScale(true);
  chart_->GetAxis(vtkAxis::RIGHT)->SetGridVisible(false);
  colour();
}

void FitChart::colour() {
  if (!chart_) return;
  const QColor base = palette().color(QPalette::Base), text = palette().color(QPalette::Text);
  const QColor line = palette().color(QPalette::Mid), main = palette().color(QPalette::Highlight);
  context_->GetRenderer()->SetBackground(base.redF(), base.greenF(), base.blueF());
  const int size = fontInfo().pixelSize() - 1;
  for (const int which : {vtkAxis::LEFT, vtkAxis::BOTTOM, vtkAxis::RIGHT}) {
    vtkAxis* axis = chart_->GetAxis(which);
    for (vtkTextProperty* property : {axis->GetLabelProperties(), axis->GetTitleProperties()}) {
      setColour(property, text);
      property->SetFontSize(size);
      property->SetBold(0);
    }
    axis->GetPen()->SetColor(text.red(), text.green(), text.blue());
    axis->GetGridPen()->SetColor(line.red(), line.green(), line.blue(), 100);
  }
  chart_->GetPlot(0)->SetColor(text.red(), text.green(), text.blue(), 160);
  for (const int plot : {1, 2})
    chart_->GetPlot(plot)->SetColor(main.red(), main.green(), main.blue(), 255);
  draw();
}

void FitChart::draw() {
  if (!chart_ || !isVisible()) return;
  const bool any = points() > 1;
  bool heldOut = false;
  for (vtkIdType row = 0; row < points() && !heldOut; ++row)
    heldOut = std::isfinite(table_->GetValue(row, HeldOut).ToDouble());
  table_->Modified();
  for (int plot = 0; plot < 3; ++plot)
    chart_->GetPlot(plot)->SetVisible(any && (plot < 2 || heldOut));
  chart_->RecalculateBounds();
  view_->renderWindow()->Render();
}

} // namespace innergs::ui
