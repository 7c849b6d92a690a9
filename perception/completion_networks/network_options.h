#pragma once

// Kind, sizes and input of completion networks.

#include <string>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

// Grid of the input, see completion/completion_input.h.
inline constexpr int kInputCells = 32;  // along each axis
inline constexpr int kInputVolume = kInputCells * kInputCells * kInputCells;
inline constexpr int kInputChannels = 4;  // signed distance, seen surface, known empty, no data
inline constexpr int kImagePixels = 64;   // along each side of the input image
inline constexpr int kImageArea = kImagePixels * kImagePixels;
inline constexpr int kImageChannels = 5;  // depth, object, background, occluder, floor
inline constexpr int kPointFacts = 10;

// Values of a query: position in the cube, -1 .. 1 along each axis; position in the image, -1 .. 1
// within it; and facts.
inline constexpr int kImagePlace = 3;  // index of the position in the image
inline constexpr int kQueryValues = kImagePlace + 2 + kPointFacts;

// Returns the names of the kinds of networks; the first is the default.
std::vector<std::string> CompletionKinds();

struct CompletionNetworkOptions {
  std::string kind = "implicit";  // of CompletionKinds()
  int width_16 = 24;              // channels at 16^3
  int width_8 = 48;               // channels at 8^3
  int width_4 = 64;               // channels at 4^3
  int bottleneck = 64;            // values that describe the whole cube
  int image_width = 16;           // implicit: channels of the image at 64^2
  int hidden = 64;                // implicit: units of each hidden layer of the decoder
  int rounds = 30;                // vae: rounds of a completion
  void Visit(SettingsVisitor& v);
};

}  // namespace pickbed::perception
