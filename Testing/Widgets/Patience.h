#pragma once

/// How long tests wait for what a busy machine may take minutes for, in milliseconds.
constexpr int kPatience = 240'000;
