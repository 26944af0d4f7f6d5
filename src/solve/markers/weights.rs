//! The weights of the marker solver, in one table.

use mocap_scene::options::weights;

weights! {
    /// The weights of [`solve_markers`](super::solve_markers): expected deviations of markers and joints.
    ///
    /// ```
    /// use mocap::Importer;
    /// use mocap::solve::MarkerWeights;
    ///
    /// // Markers on wide clothes.
    /// let importer = Importer::new().markers("auto").marker_weights(MarkerWeights::new().slide(0.03).outlier(0.1));
    /// # let _ = importer;
    /// ```
    MarkerWeights in "markers" {
        on_bone = 0.012, "m",
            "Standard deviation of the offset of a marker on a bone. It is the accuracy with which people place \
            markers: 6 to 25 mm (Della Croce et al., Gait & Posture 21, 2005).";
        on_muscle = 0.04, "m",
            "Standard deviation of the offset of a marker on a muscle: half of the width of a thigh. Marker protocols \
            do not define the exact position of such a marker.";
        hip = 0.012, "m",
            "Standard deviation of the hip centre about the position that a regression computes from the markers of \
            the pelvis. Harrington et al., J. Biomech. 40 (2007), state 3 to 8 mm per coordinate for markers on \
            bones. Markers on clothes are less precise.";
        trunk = 0.02, "m",
            "Standard deviation of the joint centres of trunk and shoulders. No regression of all their coordinates \
            is known.";
        length = 0.03, "m",
            "Standard deviation of a bone length about its first estimate. The estimate uses two centres with errors \
            from `on_bone` to `trunk`.";
        slide = 0.01, "m",
            "Largest standard deviation of a marker about its offset. mocap starts with this value, and reduces it if \
            the markers of the take slide less. Skin slides by 5 to 30 mm (Leardini et al., Gait & Posture 21, 2005).";
        least_slide = 0.001, "m",
            "Least standard deviation of a marker about its offset: the noise of cameras.";
        independent_slide = 0.05, "1",
            "Weight of a frame whose marker errors come only from sliding skin, relative to a frame whose errors are \
            independent. Skin slides almost equally in neighbouring frames, so their errors are not independent.";
        beside_hinge = 0.087, "rad",
            "Standard deviation of the rotation of a knee or an elbow outside its hinge axis: 5 degrees. In a gait, \
            knees bend sideways and twist by 5 to 10 degrees (Ramsey and Wretenberg, Clin. Biomech. 14, 1999).";
        hold = 0.35, "rad",
            "Standard deviation of a joint about its pose in the previous frame, for joints that markers do not \
            determine: 20 degrees. This value is so large that it hardly affects joints with visible markers.";
        outlier = 0.05, "m",
            "Distance of a marker from its expected position at which the marker has a quarter of its full weight \
            (Geman and McClure's function). Skin does not slide that far.";
        swapped = 0.03, "m",
            "Distance of a marker from its expected position above which the marker may have the label of another \
            marker. Skin \
            slides up to this distance.";
        swap = 0.4, "1",
            "Ratio of two distances of markers from their expected positions: with exchanged labels, to without. \
            Below this ratio, mocap exchanges the labels. Thus markers that pass each other keep their labels.";
        ghost = 0.08, "m",
            "Largest distance between a marker and its expected position. A marker farther away is a reflection, or \
            belongs to another object. Skin slides at most half of this distance.";
    }
}
