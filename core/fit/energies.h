// The terms of the energy, as every solver and report gives them.
#ifndef CAGEFIT_CORE_FIT_ENERGIES_H_
#define CAGEFIT_CORE_FIT_ENERGIES_H_

namespace cagefit {

// Already weighted; evaluated in unit coordinates, dimensionless.
struct Energies {
  double distance = 0;   // E_dist
  double arap = 0;       // alpha E_reg
  double coverage = 0;   // gamma E_cov
  double image = 0;      // beta E_img
  double landmarks = 0;  // delta E_land
  double boundary = 0;   // eta E_bound
  double total() const { return distance + arap + coverage + image + landmarks + boundary; }
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_ENERGIES_H_
