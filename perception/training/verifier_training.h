#pragma once

// Trains the verifier of one object on the estimator's own candidates, in all modes. The network
// for known backgrounds learns from clutter scenes that contain the object. The network for unknown
// backgrounds learns from rooms, of which every second is empty: all candidates there are the
// estimator's own false positives. Ground truth labels the candidates right or wrong. Then the
// score is calibrated for each background and mode on the poses that remain after pose selection:
// logistic calibration (Platt 1999). For known backgrounds these are views that were held out, for
// unknown ones the scores are cross-fitted.
//
// A network for unknown backgrounds that has learned from the rooms of many objects can be given
// (shared_verifier.h). Then the logit is the mean of the logits of this one and the object's own.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "perception/candidates/pose_selection.h"
#include "perception/candidates/vote_candidates.h"
#include "perception/features/labelled_patches.h"
#include "perception/training/training_clock.h"
#include "perception/training/verifier_fit.h"
#include "scenes/base/ids.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

// Ends of the parts of a verifier's training, for a training with a time limit. Each part still
// does its smallest useful amount: four clutter scenes and four rooms are rendered, and one view of
// each is searched. The result then depends on the speed of the machine.
struct VerifierDeadlines {
  TrainingTime views;  // of rendering the clutter scenes and rooms
  TrainingTime end;    // of the whole verifier; candidates are found until the fits need the rest
  TrainingClock now = std::chrono::steady_clock::now;
};

struct VerifierTrainingOptions {
  uint64_t seed = 0;
  int clutter_scenes = 24;  // 0 = keep the network for known backgrounds that is given
  int room_scenes = 32;  // one view of each; 0 = the network for known backgrounds is used for all
  int views_per_scene = 3;
  double calibration_share = 0.3;  // last share of the views, used for AUC and calibration
  VerifierOptions verifier;
  // Only for learned descriptors:
  int entries = 24000;                              // codebook entries of the object
  std::vector<CandidateOptions> candidates{{}};     // one per mode
  std::optional<VerifierDeadlines> deadlines = {};  // none = no time limit
  // Network for unknown backgrounds that takes part in the one of the object; may be none.
  std::optional<VerifierNetwork> shared_network = {};
  void Visit(SettingsVisitor& v);  // all except the last four
};

// An object and the network that describes its patches.
struct VerifierObject {
  ObjectId object{0};  // index into the objects of the view source
  double side_m = 0;
  int descriptor_length = 0;
  PatchVoter voter;
};

// Training set of a verifier, as far as it can be made without the network.
struct VerifierTrainingSet {
  std::vector<LabelledView> clutter_scenes;  // views of clutter scenes that contain the object
  std::vector<LabelledView> rooms;           // views of rooms, with and without the object
  LabelledPatches codes;                     // patches of the object's codebook
};

// Makes the training set of one object. on_share receives the progress, 0..1, and returns false to
// stop; the result is then incomplete. Throws InputError if no clutter scene shows the object.
VerifierTrainingSet MakeVerifierTrainingSet(LabelledViewSource& views, ObjectId object,
                                            const PatchForm& form,
                                            const VerifierTrainingOptions& options,
                                            const std::function<bool(double share)>& on_share);

// Returns the views of clutter scenes and rooms, without color images unless `color` is set.
// on_share receives the progress, 0..1, and returns false to stop; there are then fewer views.
VerifierTrainingSet VerifierScenes(LabelledViewSource& views, ObjectId object, bool color,
                                   const VerifierTrainingOptions& options,
                                   const std::function<bool(double share)>& on_share);

// Trains and calibrates the verifier of `object`, an index into the objects of the view source.
// Without clutter scenes, the network for known backgrounds is the one of `start`. Without rooms,
// or if no candidate in them is right and no network is given, it is used for all backgrounds.
// `sources` has one source per mode, in the order of CandidateMode. They look only for this object,
// so their candidates have object index 0. Modes without a source get the calibration of the first.
// on_share receives the progress, 0..1, and returns false to stop; the result is then incomplete.
// Throws InputError if all candidates are right or all are wrong.
TrainedVerifier TrainObjectVerifier(const VerifierTrainingSet& training_set, ObjectId object,
                                    std::span<const CandidateSource* const> sources,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double share)>& on_share,
                                    const TrainedVerifier* start = nullptr);

// The same with candidates from learned descriptors.
TrainedVerifier TrainObjectVerifier(const VerifierTrainingSet& training_set,
                                    const std::shared_ptr<const ObjectModel>& model,
                                    const VerifierObject& wanted,
                                    const VerifierTrainingOptions& options,
                                    const std::function<bool(double share)>& on_share,
                                    const TrainedVerifier* start = nullptr);

// Returns the candidates from learned descriptors in the rooms of the training set, labelled. Empty
// if on_share returned false.
VerifierExamples RoomExamples(const VerifierTrainingSet& training_set,
                              const std::shared_ptr<const ObjectModel>& model,
                              const VerifierObject& wanted, const VerifierTrainingOptions& options,
                              const std::function<bool(double share)>& on_share);

}  // namespace pickbed::perception
