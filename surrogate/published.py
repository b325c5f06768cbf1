"""What sections 3 and 4 of the paper print, and our choices where they are silent."""

from __future__ import annotations

# Figure: its title, what the paper shows there.
FIGURES = {
    "fig4": (
        "Workspace",
        "1520 tip positions of the 40 cm arm under swept moments, with frames (x red, y green, z blue) at"
        " some.",
    ),
    "fig5": ("A pose as an image", "Position and gradients stacked to a 3 x 4 image."),
    "fig6": ("The CNN", "Convolution, pooling, flatten, dense layers; tanh; sizes not printed."),
    "fig7": (
        "Losses",
        "MSE of training and validation over 500 epochs; both fall to a common minimum. No scale in the"
        " text.",
    ),
    "fig8": (
        "Targets and estimates",
        "Moments of the first 100 test samples, absolute errors, their means as red lines; called"
        " negligible.",
    ),
    "fig9": (
        "Reference trajectory",
        "Constant-curvature trajectory (eq. 47-48) among the samples, and two projections.",
    ),
    "fig10": (
        "Trajectory through ANCF",
        "The trajectory and the one of ANCF under the CNN's moments; the deviations, centimetres below z ="
        " 0.2 m, are put down to few samples there and to the constant-curvature model.",
    ),
    "fig11": (
        "Five-fold cross-validation",
        "Training losses of all networks and folds, larger networks in darker red; mean and deviation of the"
        " MSE.",
    ),
}

# Item, what the paper prints, what is done here.
DECISIONS = (
    (
        "radius, E, range of moments (sec. 3.1)",
        "unpublished",
        "those of the data set; 20 units are its largest moment",
    ),
    ("formulation (eq. 11-16)", "continuum", "enhanced: continuum is too stiff in bending at every mesh"),
    (
        "grid of 1520 samples (sec. 3.1)",
        "unpublished",
        "4 x 19 x 20 over torsion and bending about both axes",
    ),
    ("test samples (sec. 4.1)", "512", "15 % of 1520 is 228"),
    ('"kernel size 16" (sec. 3.2)', "does not fit a 3 x 4 image", "16 kernels of 2 x 2"),
    ("pooling and dense widths (fig. 6)", "not printed", "mean over 2 x 1; dense 32, tanh; dense 3, linear"),
    (
        "scale of the targets",
        "not printed; MSE > 1 excludes z-scores",
        "units of which the largest moment has 20",
    ),
    (
        "batch of the five-fold table",
        "not printed",
        "32, the default of TensorFlow; the main CNN has the printed 64",
    ),
    (
        "order of table 1",
        "5 < 1 < 4 < 3 < 2, one run",
        "5 first; 1 and 4, and 3 and 2, are nearer each other than single runs scatter",
    ),
    ("start of the weights", "not printed", "Glorot's uniform, zero biases: the defaults of TensorFlow"),
    ("eq. 47, entry (2,2)", "cos^2 phi: no rotation", "sin^2 phi"),
    (
        "fig. 10, mismatch of CCM and ANCF",
        "explained by the models",
        "the arc is the thin arm's; what remains is (R/L)^2",
    ),
)
