#pragma once
#include <QTest>

/// How long tests wait for what a busy machine may take minutes for, in milliseconds.
constexpr int kPatience = 240'000;

// Qt's own wait five seconds only.
#define TRY_VERIFY(condition) QTRY_VERIFY_WITH_TIMEOUT(condition, kPatience)
#define TRY_VERIFY2(condition, message) QTRY_VERIFY2_WITH_TIMEOUT(condition, message, kPatience)
#define TRY_COMPARE(actual, expected) QTRY_COMPARE_WITH_TIMEOUT(actual, expected, kPatience)
