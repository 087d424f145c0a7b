#include "common/det_math.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

// Polynomial coefficients: the minimax fits published with FreeBSD msun (fdlibm), on the usual reduced
// ranges.
namespace evograsp::det {
namespace {

// sin on [-pi/4, pi/4].
double sin_kernel(double x) {
  const double z = x * x;
  const double r = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 +
                        z * (2.75573137070700676789e-06 +
                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return x + x * z * (-1.66666666666666324348e-01 + z * r);
}

// cos on [-pi/4, pi/4].
double cos_kernel(double x) {
  const double z = x * x;
  const double r = z * (4.16666666666666019037e-02 +
                        z * (-1.38888888888741095749e-03 +
                             z * (2.48015872894767294178e-05 +
                                  z * (-2.75573143513906633035e-07 +
                                       z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + z * r);
}

// x = quadrant * pi/2 + remainder, by pi/2 in three parts (Cody and Waite).
struct Reduced {
  double remainder;
  int quadrant;
};

Reduced reduce(double x) {
  constexpr double kTwoOverPi = 6.36619772367581382433e-01;
  constexpr double kHigh = 1.57079632673412561417e+00;    // 33 bits
  constexpr double kMiddle = 6.07710050630396597660e-11;  // 33 more
  constexpr double kLow = 2.02226624879595063154e-21;
  const double n = std::floor(x * kTwoOverPi + 0.5);
  const double r = ((x - n * kHigh) - n * kMiddle) - n * kLow;
  return {r, static_cast<int>(static_cast<std::int64_t>(n) & 3)};
}

bool out_of_range(double x) {
  return !(std::fabs(x) <= 1e5);
}

double scale_by_power_of_two(double x, int k) {
  if (k > 1000)
    return x * 0x1p1000 * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + k - 1000) << 52);
  if (k < -1000)
    return x * 0x1p-1000 * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + k + 1000) << 52);
  return x * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + k) << 52);
}

}  // namespace

double sin(double x) {
  double s, c;
  sincos(x, &s, &c);
  return s;
}

double cos(double x) {
  double s, c;
  sincos(x, &s, &c);
  return c;
}

void sincos(double x, double* s, double* c) {
  if (out_of_range(x)) {
    *s = *c = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const Reduced r = reduce(x);
  const double sine = sin_kernel(r.remainder);
  const double cosine = cos_kernel(r.remainder);
  switch (r.quadrant) {
    case 0:
      *s = sine;
      *c = cosine;
      break;
    case 1:
      *s = cosine;
      *c = -sine;
      break;
    case 2:
      *s = -sine;
      *c = -cosine;
      break;
    default:
      *s = -cosine;
      *c = sine;
      break;
  }
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.782712893383973096) return std::numeric_limits<double>::infinity();
  if (x < -745.13321910194110842) return 0.0;
  constexpr double kLn2High = 6.93147180369123816490e-01;
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  const double k = std::floor(x * 1.44269504088896338700e+00 + 0.5);
  const double high = x - k * kLn2High;
  const double low = k * kLn2Low;
  const double r = high - low;
  const double z = r * r;
  const double c = r - z * (1.66666666666666019037e-01 +
                            z * (-2.77777777770155933842e-03 +
                                 z * (6.61375632143793436117e-05 +
                                      z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  const double y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
  return scale_by_power_of_two(y, static_cast<int>(k));
}

double log(double x) {
  if (std::isnan(x) || x < 0) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0) return -std::numeric_limits<double>::infinity();
  if (std::isinf(x)) return x;
  int k = 0;
  if (x < 0x1p-1022) {
    x *= 0x1p54;
    k = -54;
  }
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<int>(bits >> 52) - 1023;
  bits = (bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL;
  double m = std::bit_cast<double>(bits);
  if (m > 1.41421356237309514547) {
    m *= 0.5;
    ++k;
  }
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double r =
      z * (6.666666666666735130e-01 +
           z * (3.999999999940941908e-01 +
                z * (2.857142874366239149e-01 +
                     z * (2.222219843214978396e-01 +
                          z * (1.818357216161805012e-01 +
                               z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01))))));
  const double half = 0.5 * f * f;
  const double dk = k;
  return dk * 6.93147180369123816490e-01 - ((half - (s * (half + r) + dk * 1.90821492927058770002e-10)) - f);
}

double tanh(double x) {
  const double a = std::fabs(x);
  if (std::isnan(x)) return x;
  if (a > 22.0) return std::copysign(1.0, x);
  double t;
  if (a < 0.25) {
    // Odd Taylor series through x^21: no cancellation near zero.
    const double z = a * a;
    constexpr double c[] = {-0.33333333333333333,   0.13333333333333333,    -0.053968253968253968,
                            0.021869488536155203,   -0.0088632355299021966, 0.0035921280365724810,
                            -0.0014558343870513183, 0.00059002744094558598, -0.00023912911424355248,
                            0.000096915379569294509};
    double p = 0;
    for (int i = 9; i >= 0; --i) p = c[i] + z * p;
    t = a + a * z * p;
  } else {
    const double e = det::exp(2.0 * a);
    t = 1.0 - 2.0 / (e + 1.0);
  }
  return std::copysign(t, x);
}

double atan(double x) {
  if (std::isnan(x)) return x;
  const double a = std::fabs(x);
  if (a >= 0x1p66) return std::copysign(1.57079632679489655800e+00, x);
  constexpr double kHigh[] = {4.63647609000806093515e-01, 7.85398163397448278999e-01,
                              9.82793723247329054082e-01, 1.57079632679489655800e+00};
  constexpr double kLow[] = {2.26987774529616870924e-17, 3.06161699786838301793e-17,
                             1.39033110312309984516e-17, 6.12323399573676603587e-17};
  int id = -1;
  double t = a;
  if (a >= 0.4375) {
    if (a < 0.6875) {
      id = 0;
      t = (2.0 * a - 1.0) / (2.0 + a);
    } else if (a < 1.1875) {
      id = 1;
      t = (a - 1.0) / (a + 1.0);
    } else if (a < 2.4375) {
      id = 2;
      t = (a - 1.5) / (1.0 + 1.5 * a);
    } else {
      id = 3;
      t = -1.0 / a;
    }
  }
  const double z = t * t;
  const double w = z * z;
  const double even =
      z * (3.33333333333329318027e-01 +
           w * (1.42857142725034663711e-01 +
                w * (9.09088713343650656196e-02 +
                     w * (6.66107313738753120669e-02 +
                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double odd = w * (-1.99999999998764832476e-01 +
                          w * (-1.11111104054623557880e-01 +
                               w * (-7.69187620504482999495e-02 +
                                    w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  const double y = id < 0 ? t - t * (even + odd) : kHigh[id] - ((t * (even + odd) - kLow[id]) - t);
  return std::copysign(y, x);
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0 && y == 0) return std::signbit(x) ? std::copysign(kPi, y) : y;
  if (x == 0) return std::copysign(kPi / 2, y);
  if (std::isinf(x) && std::isinf(y)) return std::copysign(x > 0 ? kPi / 4 : 3 * kPi / 4, y);
  const double t = det::atan(std::fabs(y / x));
  return std::copysign(x > 0 ? t : kPi - (t - 1.2246467991473531772e-16), y);
}

double acos(double x) {
  if (x >= 1) return 0;
  if (x <= -1) return kPi;
  return det::atan2(std::sqrt((1 - x) * (1 + x)), x);
}

double asin(double x) {
  if (x >= 1) return kPi / 2;
  if (x <= -1) return -kPi / 2;
  return det::atan2(x, std::sqrt((1 - x) * (1 + x)));
}

}  // namespace evograsp::det
