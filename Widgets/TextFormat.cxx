#include "Widgets/TextFormat.h"

#include "Core/Base/Quantities.h"

#include <QCoreApplication>
#include <QLocale>

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs::ui {
namespace {

struct TextFormat {
  Q_DECLARE_TR_FUNCTIONS(innergs::ui::TextFormat)
};

/// With the locale's separators; a number has only one kind of them.
QString localized(const std::string& number) {
  QString text = QString::fromStdString(number);
  return text.contains(QLatin1Char(',')) ? text.replace(QLatin1Char(','), QLocale().groupSeparator())
                                         : text.replace(QLatin1Char('.'), QLocale().decimalPoint());
}

} // namespace

QString roughDuration(double seconds) {
  if (!(seconds >= 5)) return TextFormat::tr("a few seconds");
  if (seconds < 20)
    return TextFormat::tr("about %n seconds", nullptr, 5 * static_cast<int>(std::lround(seconds / 5)));
  if (seconds < 55)
    return TextFormat::tr("about %n seconds", nullptr, 10 * static_cast<int>(std::lround(seconds / 10)));
  if (seconds < 90) return TextFormat::tr("about a minute");
  const int minutes = static_cast<int>(std::ceil(std::min(seconds, 1e9) / 60 - 0.25));
  if (minutes < 55) return TextFormat::tr("about %n minutes", nullptr, minutes);
  const int tens = (minutes + 5) / 10;
  const int hours = tens / 6, rest = tens % 6 * 10;
  if (hours >= 48) return TextFormat::tr("about %n days", nullptr, (hours + 12) / 24);
  const QString text =
      hours == 1 ? TextFormat::tr("about 1 hour") : TextFormat::tr("about %n hours", nullptr, hours);
  return rest == 0 || hours >= 6 ? text
                                 : TextFormat::tr("%1 %n minutes", "hours and minutes", rest).arg(text);
}

QString exactDuration(double seconds) {
  if (!(seconds > 0)) seconds = 0;
  if (seconds < 59.95)
    return TextFormat::tr("%1 s").arg(QLocale().toString(seconds, 'f', seconds < 9.95 ? 1 : 0));
  const auto total = static_cast<long long>(std::llround(std::min(seconds, 1e12)));
  const auto padded = [](long long n) { return QString("%1").arg(n, 2, 10, QChar('0')); };
  if (total < 3600) return TextFormat::tr("%1 min %2 s").arg(total / 60).arg(padded(total % 60));
  return TextFormat::tr("%1 h %2 min").arg(total / 3600).arg(padded(total % 3600 / 60));
}

QString memorySize(std::int64_t bytes) {
  return localized(bytesText(static_cast<double>(bytes)));
}

QString countText(std::int64_t count) {
  return localized(innergs::countText(count));
}

QString gaussiansText(std::int64_t count) {
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  const int number = static_cast<int>(std::min(count, most));
  QString text = TextFormat::tr("%Ln Gaussians", nullptr, number);
  return text.replace(QLocale().toString(number), countText(number)); // the C locale groups no digits
}

QString shownGaussiansText(std::int64_t shown, std::int64_t all) {
  return TextFormat::tr("Showing %1 of %2", "20,000, 1,045,528 Gaussians")
      .arg(countText(shown), gaussiansText(all));
}

QString methodText(const QString& method) {
  const QString name = method.toLower();
  if (name == QLatin1String("gaussians")) return TextFormat::tr("InnerGS");
  if (name == QLatin1String("linear")) return TextFormat::tr("Linear interpolation");
  if (name == QLatin1String("cubic")) return TextFormat::tr("Cubic interpolation");
  if (name == QLatin1String("lanczos")) return TextFormat::tr("Lanczos interpolation");
  if (name == QLatin1String("average")) return TextFormat::tr("Average of the scans");
  if (name == QLatin1String("backprojection")) return TextFormat::tr("Back-projection");
  if (name == QLatin1String("totalvariation")) return TextFormat::tr("Total variation");
  return method;
}

QString phaseText(Phase phase) {
  return QCoreApplication::translate("innergs", phaseName(phase));
}

QString lengthText(double mm) {
  return localized(innergs::lengthText(mm));
}

QString sentence(const QString& text) {
  QString line = text.simplified();
  if (line.isEmpty() || line.endsWith('.') || line.endsWith('!') || line.endsWith('?')) return line;
  return line + '.';
}

} // namespace innergs::ui
