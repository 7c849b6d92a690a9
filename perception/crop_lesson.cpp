#include "perception/crop_lesson.h"

namespace pickbed {
namespace {

void AppendAll(const ObjectCrops& from, ObjectCrops& to) {
  to.R_CO.insert(to.R_CO.end(), from.R_CO.begin(), from.R_CO.end());
  for (size_t i = 0; i < from.crops.size(); ++i) AppendRow(from.crops, i, to.crops);
}

}  // namespace

CropLesson MakeCropLesson(LabelledViewSource& clean, LabelledViewSource& varied,
                          const CropViewOptions& options, uint64_t seed,
                          const std::function<bool(double share)>& on_share) {
  CropLesson lesson{clean.objects(), {}, {}};
  const Rotations templates = TemplateRotations(options), further = TrainingRotations(options);
  Rotations all = templates;
  all.insert(all.end(), further.begin(), further.end());
  const int parts = static_cast<int>(lesson.objects.size());
  for (int part = 0; part < parts; ++part) {
    if (on_share && !on_share(1.0 * part / parts)) break;
    const auto stream = [&](const char* name) { return Rng::Derive(seed, part, name).Next(); };
    lesson.templates.push_back(RenderCrops(clean, part, templates, options, stream("templates")));
    lesson.training.push_back(RenderCrops(clean, part, further, options, stream("further")));
    AppendAll(RenderCrops(varied, part, all, options, stream("varied")), lesson.training.back());
  }
  return lesson;
}

}  // namespace pickbed
