% mkoctfile --mex vibroimpact.c -lvibroimpact (Octave) or mex vibroimpact.c -lvibroimpact (MATLAB), once
result = vibroimpact(['&system xi = 0.0114, mu = 0.028, restitution = 0.75 /' 10 ...
    '&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, states = 6 /' 10]);
points = result.points;
fprintf('%.2f %.10f %.10f\n', [points.r, points.lowest, points.highest]');
