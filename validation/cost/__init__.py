"""What accuracy costs in time: problem families and single scenes, elements, solids and peers on one axis."""
