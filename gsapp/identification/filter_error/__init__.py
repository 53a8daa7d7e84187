"""Filter error: residuals and sensitivities seen through one Kalman filter.

A steady-state filter with turbulence in its process noise turns the residuals of all channels, and
what each parameter would change in them, into innovations. Without turbulence these are the
residuals of output error, in strong turbulence nearly those of equation error: one method for calm
and rough air (Maine and Iliff, AGARD-AG-300-3, section 5; Jategaonkar, Flight Vehicle System
Identification, chapter 5). In innovations a missing effect is a linear regression, and every
comparison of models is small linear algebra. One pass of a fit, from top to bottom:

    create_maneuver_record    samples and measured motion of a maneuver     motion_linearization
    linearize_along           the model along a motion near it              motion_linearization
    create_filter             blocks of samples, noise, steady covariance   kalman
    filter_columns            innovations of residual and parameters        maneuver_state
    information_of            their normal equations                        filter_error_fit
    apply_step                parameters and predicted motion moved         filter_error_fit
    tune_noise                noise to what the smoother sees               noise_tuning

`fit_to_convergence` repeats passes; `steady_state` holds the predictor of any linear system, which
data compatibility uses, too.
"""
