#include "perception/training/perceptron_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/math.h"
#include "scenes/base/random.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

double LogOdds(const FittedPerceptron& net, const std::vector<float>& values) {
  const Eigen::Map<const Eigen::VectorXf> raw(values.data(),
                                              static_cast<Eigen::Index>(values.size()));
  Eigen::VectorXf x = ((raw - net.mean).array() / net.scale.array()).max(-4.0f).min(4.0f);
  for (size_t i = 0; i < net.layers.size(); ++i) {
    Eigen::VectorXf next = net.layers[i].weights * x + net.layers[i].bias;
    if (i + 1 < net.layers.size()) next = next.cwiseMax(0.0f);
    x.swap(next);
  }
  return x(0);
}

// Labels of known probability: the fit must give this probability, not only the order.
TEST(PerceptronFit, EstimatesTheProbabilityOfARuleThatIsNotLinear) {
  Rng rng(1);
  const auto probability = [](float a, float b) { return a * b > 0 ? 0.9 : 0.3; };
  PerceptronExamples examples{3, {}, {}};
  for (int i = 0; i < 8000; ++i) {
    const float a = static_cast<float>(rng.Normal()), b = static_cast<float>(rng.Normal());
    examples.values.insert(examples.values.end(),
                           {5 * a + 100, b, static_cast<float>(rng.Normal())});
    examples.label.push_back(rng.Uniform() < probability(a, b));
  }
  PerceptronOptions options;
  options.dropout = options.input_dropout = 0.02;
  const FittedPerceptron net = FitPerceptron(examples, options, 0);
  for (const float a : {-1.5f, 1.5f}) {
    for (const float b : {-1.5f, 1.5f}) {
      EXPECT_NEAR(Logistic(LogOdds(net, {5 * a + 100, b, 0})), probability(a, b), 0.12)
          << a << " " << b;
    }
  }
}

TEST(PerceptronFit, TheSameSeedGivesTheSameWeights) {
  Rng rng(2);
  PerceptronExamples examples{2, {}, {}};
  for (int i = 0; i < 300; ++i) {
    examples.values.push_back(static_cast<float>(rng.Normal()));
    examples.values.push_back(static_cast<float>(rng.Normal()));
    examples.label.push_back(examples.values.back() > 0);
  }
  PerceptronOptions options;
  options.epochs = 2;
  const FittedPerceptron a = FitPerceptron(examples, options, 7),
                         b = FitPerceptron(examples, options, 7),
                         c = FitPerceptron(examples, options, 8);
  EXPECT_EQ(a.layers[0].weights, b.layers[0].weights);
  EXPECT_NE(a.layers[0].weights, c.layers[0].weights);
  examples.label.assign(examples.label.size(), 1);
  EXPECT_THAT(ErrorOf([&] { FitPerceptron(examples, options, 7); }), HasSubstr("both labels"));
}

}  // namespace
}  // namespace pickbed::tests
