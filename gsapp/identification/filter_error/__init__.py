"""Filter-error regression: residuals and sensitivities seen through one Kalman filter.

A model is linearized along a motion near the measured one (`linearizing`); a steady-state filter
with turbulence in its process noise (`noise`, `kalman`) turns the residuals of all channels, and
what each parameter would change in them, into innovations. Without turbulence these are the
residuals of output error, in strong turbulence nearly those of equation error: one method for calm
and rough air (Maine and Iliff, AGARD-AG-300-3, section 5; Jategaonkar, Flight Vehicle System
Identification, chapter 5). In innovations a missing effect is a linear regression, and every
comparison of models is small linear algebra on `Information` matrices.
"""
