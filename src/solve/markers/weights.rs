//! The weights of solving markers, from one table.

use mocap_scene::options::weights;

weights! {
    /// The weights of [`solve_markers`](super::solve_markers): how far markers and joints are expected to be off.
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
            "Standard deviation of the offset of a marker on a bone: people place markers that precisely (Della Croce \
            et al., Gait & Posture 21, 2005, report 6 to 25 mm).";
        on_muscle = 0.04, "m",
            "Standard deviation of the offset of a marker on a muscle, whose place no protocol states: half of the \
            width of a thigh.";
        hip = 0.012, "m",
            "Standard deviation of the centre of a hip about its regression. Harrington et al., J. Biomech. 40 \
            (2007), state 3 to 8 mm per coordinate for markers on bones; markers on clothes are farther off.";
        trunk = 0.02, "m",
            "Standard deviation of the centre of a joint of the trunk and of a shoulder, for which no regression of \
            all coordinates is known.";
        length = 0.03, "m",
            "Standard deviation of the length of a bone about the first estimate from two centres, each of which is \
            off by `on_bone` to `trunk`.";
        slide = 0.01, "m",
            "Standard deviation of a marker about its offset before the take tells. Skin slides by 5 to 30 mm \
            (Leardini et al., Gait & Posture 21, 2005).";
        least_slide = 0.001, "m",
            "Least standard deviation of a marker about its offset: the noise of cameras is as much.";
        independent_slide = 0.05, "1",
            "Fraction of an independent frame for which a frame counts whose markers are off because skin slides: it \
            slides in the next frame much as in this one.";
        beside_hinge = 0.087, "rad",
            "Standard deviation of a knee or an elbow beside the axis of its hinge: 5 degrees. Knees bend aside and \
            turn by 5 to 10 degrees in a gait (Ramsey and Wretenberg, Clin. Biomech. 14, 1999).";
        hold = 0.35, "rad",
            "Standard deviation of a joint about its pose in the frame before, where markers do not say: 20 degrees, \
            so that markers that are seen hardly feel it.";
        outlier = 0.05, "m",
            "Distance of a marker from its body at which it has a quarter of its weight (Geman and McClure's \
            function): skin does not slide as far.";
        swapped = 0.03, "m",
            "Distance from its body above which a marker may have the label of another: as far as skin slides.";
        swap = 0.4, "1",
            "Ratio of distances below which two labels are exchanged: clearly nearer, so that markers that pass each \
            other are not.";
        ghost = 0.08, "m",
            "Distance from its body above which a marker is a reflection, or belongs to something else: twice as far \
            as skin slides.";
    }
}
