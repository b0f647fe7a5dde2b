#pragma once
#include "Core/Settings/Settings.h"
#include "Widgets/NumberSpin.h"

#include <QCheckBox>
#include <QComboBox>
#include <QFormLayout>
#include <QSignalBlocker>

#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace innergs::ui {

/// Widgets bound to members of innergs::Settings. A widget writes only the member that the user edits, so
/// that what was set comes back as it was. `access`: a generic lambda from Settings to the member.
class FieldForm : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;
  struct Text {
    const char* name; // of the object
    QString label, tip;
  };
  template <class T>
  using Choices = std::vector<std::pair<QString, T>>;

  void setLayout(QFormLayout* form) { form_ = form; }
  Settings settings;
  /// The widgets show `settings`.
  void show() {
    for (const auto& write : writers_)
      write();
  }

  /// A combo box of a plain or an optional member; an optional one begins with "automatic".
  template <class T, class Access>
  QComboBox* addChoice(const Text& text, const Choices<T>& choices, Access access) {
    auto* combo = new QComboBox;
    using Member = std::remove_reference_t<decltype(access(settings))>;
    if (isOptional<Member>) combo->addItem(tr("automatic"));
    for (const auto& choice : choices)
      combo->addItem(choice.first);
    combo->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    combo->setSizeAdjustPolicy(QComboBox::AdjustToContents);
    writers_.push_back([=, this] {
      const QSignalBlocker quiet(combo);
      int index = -1;
      for (std::size_t i = 0; i < choices.size(); ++i)
        if (access(std::as_const(settings)) == choices[i].second) index = static_cast<int>(i);
      combo->setCurrentIndex(index + (isOptional<Member> ? 1 : 0));
    });
    connect(combo, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [=, this](int index) {
      auto& member = access(settings);
      if constexpr (isOptional<Member>) {
        if (index == 0)
          member.reset();
        else
          member = choices[index - 1].second;
      } else {
        member = choices[index].second;
      }
      Q_EMIT changed();
    });
    add(text, combo);
    return combo;
  }

  template <class Access>
  QComboBox* addYesNo(const Text& text, Access access) {
    return addChoice<bool>(text, {{tr("yes"), true}, {tr("no"), false}}, access);
  }

  template <class Access>
  NumberSpin* addNumber(const Text& text, NumberSpin::Range range, Access access) {
    using Member = std::remove_reference_t<decltype(access(settings))>;
    range.automatic = isOptional<Member>;
    range.integer = isInteger<Member>;
    auto* spin = new NumberSpin(range);
    writers_.push_back([=, this] {
      const QSignalBlocker quiet(spin);
      const auto& member = access(std::as_const(settings));
      if constexpr (isOptional<Member>)
        spin->setNumber(member ? std::optional<double>(static_cast<double>(*member)) : std::nullopt);
      else
        spin->setNumber(static_cast<double>(member));
    });
    connect(spin, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [=, this] {
      auto& member = access(settings);
      if constexpr (isOptional<Member>) {
        if (const auto number = spin->number())
          member = static_cast<typename Member::value_type>(*number);
        else
          member.reset();
      } else {
        member = static_cast<Member>(spin->value());
      }
      Q_EMIT changed();
    });
    add(text, spin);
    return spin;
  }

  template <class Access>
  QCheckBox* addCheck(const Text& text, Access access) {
    auto* box = new QCheckBox(text.label);
    box->setObjectName(text.name);
    box->setToolTip(text.tip);
    form_->addRow(box);
    writers_.push_back([=, this] {
      const QSignalBlocker quiet(box);
      box->setChecked(access(std::as_const(settings)));
    });
    connect(box, &QCheckBox::toggled, this, [=, this](bool on) {
      access(settings) = on;
      Q_EMIT changed();
    });
    return box;
  }

Q_SIGNALS:
  void changed();

private:
  template <class T>
  struct Optional : std::false_type {
    using type = T;
  };
  template <class T>
  struct Optional<std::optional<T>> : std::true_type {
    using type = T;
  };
  template <class T>
  static constexpr bool isOptional = Optional<std::remove_cv_t<std::remove_reference_t<T>>>::value;
  template <class T>
  static constexpr bool isInteger =
      std::is_integral_v<typename Optional<std::remove_cv_t<std::remove_reference_t<T>>>::type>;

  void add(const Text& text, QWidget* widget) {
    widget->setObjectName(text.name);
    widget->setToolTip(text.tip);
    form_->addRow(text.label, widget);
    if (QWidget* label = form_->labelForField(widget)) label->setToolTip(text.tip);
  }

  QFormLayout* form_ = nullptr;
  std::vector<std::function<void()>> writers_;
};

} // namespace innergs::ui
