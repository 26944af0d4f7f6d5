//! The table of codes, each with its cause and remedy.

use std::fmt;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Declares [`Code`] from one table, so that a code, its name, its cause and its remedy stay together.
macro_rules! codes {
    ($($variant:ident $name:literal $cause:literal $remedy:literal)*) => {
        /// The stable name of a diagnostic. [`Error`](crate::Error) has an example.
        ///
        /// | code | cause | what to do |
        /// |---|---|---|
        $(#[doc = concat!("| `", $name, "` | ", $cause, " | ", $remedy, " |")])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Code {
            $(#[doc = $cause] $variant,)*
        }

        impl Code {
            /// All codes, in the order of the table.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name in kebab case. The name does not change between versions.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Whether a warning with this code means that frames of the file are lost. Such a warning fails `mocap
            /// check`.
            ///
            /// ```
            /// use mocap::{Code, Importer};
            ///
            /// let cut = b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 3 Frame Time: 0.1\n10\n";
            /// let scene = Importer::new().read(cut, "a.bvh")?;
            /// assert_eq!(scene.warnings[0].code, Code::MissingFrames);
            /// assert!(scene.warnings[0].code.loses_frames());
            /// # Ok::<(), mocap::Error>(())
            /// ```
            pub const fn loses_frames(self) -> bool {
                matches!(self, Self::MissingFrames | Self::RowLength)
            }

            /// The cause of the problem.
            pub const fn cause(self) -> &'static str {
                match self { $(Self::$variant => $cause,)* }
            }

            /// The remedy.
            pub const fn remedy(self) -> &'static str {
                match self { $(Self::$variant => $remedy,)* }
            }
        }
    };
}

codes! {
    Io "io"
        "The operating system refused to read or write the file."
        "Check the path and the permissions."
    MissingFile "missing-file"
        "The file needs a second file, which is missing or ambiguous."
        "Put the second file into the same folder, or name it, for example a motion's skeleton with the option \
            skeleton."
    OutputIsInput "output-is-input"
        "The output would replace one of the input files, perhaps through a link."
        "Name another output."
    OutputExists "output-exists"
        "The output would replace a file that mocap did not write, or that was changed later."
        "Name another output, or replace the file with the option force."
    UnknownFormat "unknown-format"
        "Neither the contents nor the extension belong to a format that mocap reads."
        "Name the format, or convert the file to BVH first."
    UnknownOption "unknown-option"
        "No option, step or key has this name."
        "Use one of the names in the help text."
    InvalidValue "invalid-value"
        "The value of an option is not valid, or not valid for this file."
        "Choose one of the values in the help text."
    EmptyFile "empty-file"
        "The file is empty."
        "Export or download it again."
    BinaryFile "binary-file"
        "The file holds bytes that a text file cannot hold."
        "Check that the file is not compressed, and that its format matches its extension."
    MissingKeyword "missing-keyword"
        "A section or a line that the format requires is missing."
        "Add it, or export the file again."
    UnexpectedToken "unexpected-token"
        "The format does not allow this word here."
        "Correct the word at the stated location."
    UnexpectedEnd "unexpected-end"
        "The file ends inside a section."
        "The file is cut off: export or download it again."
    InvalidNumber "invalid-number"
        "A number is expected, and the word is not a number."
        "Correct the number at the location named."
    NonFiniteOffset "non-finite-offset"
        "An OFFSET, or a number of a bone in an Acclaim skeleton, is NaN, infinite, or at least 1e18."
        "Correct the number at the location named."
    NumberRange "number-range"
        "A number is too large or too small to compute with: it is not finite, or at least 1e18, or a scale below \
            1e-12 other than 0."
        "Correct the number, or export the file again."
    UnknownChannel "unknown-channel"
        "CHANNELS, or the dof or order of an Acclaim skeleton, names a channel that does not exist."
        "Use Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation, Xscale, Yscale or Zscale; in Acclaim's \
            files tx, ty, tz, rx, ry, rz or l."
    ChannelCount "channel-count"
        "The number after CHANNELS is not the number of names that follow."
        "Correct the number, or complete the names."
    FrameTime "frame-time"
        "The frame time is missing, zero, negative, not a number, or implausible: the frame rate is below 0.0001 or \
            above 1,000,000 frames per second."
        "State the frame rate yourself, with the option retime."
    RowLength "row-length"
        "A row of the motion has more or fewer values than the hierarchy has channels."
        "Correct the row, or export the file again."
    LimitExceeded "limit-exceeded"
        "A count or a size in the file is larger than `Limits` allows."
        "Raise the limit if you trust the file."
    FrameCount "frame-count"
        "The motion has more frames than the file states, or keys outside the stated range."
        "Correct the number or the range in the file. The option all-rows reads the further rows of BVH."
    MissingFrames "missing-frames"
        "The motion has fewer frames than the file states: the file is cut off, or states a wrong number."
        "Export or download the file again. The available frames were read."
    HeaderCount "header-count"
        "A count or a range that the file states differs from its data. The data were read."
        "Export the file again."
    UnknownUnit "unknown-unit"
        "The output format is in metres, but the unit of the scene is different or unknown. Or the unit of a marker \
            file is wrong: no body fits its markers."
        "Apply a `Conversion` before writing, or set `Metadata::metres_per_unit` to 1 if the lengths are metres."
    StatedOtherwise "stated-otherwise"
        "An option and the file state different units or up axes of the input. The option was used."
        "Omit the option if the file is right. To change the output, use the options of the output."
    ImplausibleSize "implausible-size"
        "With the unit that the file or an option states, the figure is far larger or smaller than a person."
        "State the right unit of the input, if the figure is a person."
    NonFiniteValue "non-finite-value"
        "A value of the motion is NaN, infinite, or at least 1e18. The last valid value of its channel was used."
        "Repair the capture at the stated frames."
    TrailingText "trailing-text"
        "Text, lines with a different number of values, or bytes follow the last row or table of the motion. They \
            were ignored."
        "Remove it."
    RepeatedOffset "repeated-offset"
        "A joint has more than one OFFSET; the last one was used."
        "Keep only one OFFSET in the joint."
    LongOffset "long-offset"
        "An OFFSET has more than three numbers; the first three were used."
        "Remove the others."
    RepeatedChannels "repeated-channels"
        "A joint has more than one CHANNELS line. A repeated line was ignored; different lines were joined."
        "Join the lines into one CHANNELS line."
    RepeatedChannel "repeated-channel"
        "A joint names a channel twice. Rotations were multiplied; for positions and scales the last value was used."
        "Remove one of the two."
    DecimalComma "decimal-comma"
        "Numbers have a decimal comma; it was read as a decimal point."
        "Export with a locale that has decimal points."
    SplitNumber "split-number"
        "Two numbers have no space between them; they were split before the sign."
        "Put a space between the numbers."
    MissingBrace "missing-brace"
        "MOTION begins before all joints are closed; they were closed there."
        "Add the closing braces."
    WorldPositions "world-positions"
        "The positions of joints other than the root are far beyond the length of their OFFSETs: they seem to be \
            world positions."
        "Export positions relative to the parent, or only the root's."
    MissingMotion "missing-motion"
        "`Frames:` follows the hierarchy without MOTION; the rows after it were read."
        "Write MOTION before `Frames:`."
    NestedEndSite "nested-end-site"
        "An End Site is within an End Site; it was read as its child."
        "Make the outer End Site a JOINT, or remove one of the two."
    ExtraBrace "extra-brace"
        "A closing brace has no opening brace; it was ignored."
        "Remove it."
    JointOutsideRoot "joint-outside-root"
        "A JOINT follows the closing brace of its ROOT; it was attached to the root."
        "Move the closing brace after the joint."
    SeveralRoots "several-roots"
        "The hierarchy has more than one ROOT; the roots got a common parent node."
        "Give each skeleton its own file to keep them apart."
    DuplicateName "duplicate-name"
        "Several nodes have one name; the names were kept, and each node has its own channel."
        "Rename them if another program finds nodes by name."
    ErrorBound "error-bound"
        "The chosen number format cannot keep the error below the limit."
        "Allow a larger error, or store 32-bit floats, without compression."
    MissingFeature "missing-feature"
        "The file needs a feature that this build does not have."
        "Build the program with the stated feature."
    Unrepresentable "unrepresentable"
        "The scene has data that the output format cannot hold."
        "Correct the scene at the stated node, or remove that data."
    NotCarriedOver "not-carried-over"
        "The input has data that the output lacks, because the reader or the format cannot hold it."
        "Ignore this if you do not need the data; otherwise write another format (docs/losses.md)."
    UnreadableFormat "unreadable-format"
        "The format is known, but cannot be read."
        "Export BVH or FBX from the program that wrote the file."
    InvalidFbx "invalid-fbx"
        "The file is not valid FBX."
        "Export or download it again."
    InvalidUsd "invalid-usd"
        "The file is not valid USD, or has no UsdSkel skeleton."
        "Export it again, as one layer, for example with `usdcat`."
    InvalidMmd "invalid-mmd"
        "The file is not a valid MikuMikuDance model or motion."
        "Export or download it again."
    InvalidGltf "invalid-gltf"
        "The file is not valid glTF, or requires an extension that cannot be read."
        "Write it again without required extensions, or check it with the Khronos validator."
    InvalidXml "invalid-xml"
        "The file is not valid XML."
        "Correct the stated location, or export the file again."
    InvalidRobot "invalid-robot"
        "The links and joints of a robot contradict each other, or one of their values is not valid."
        "Correct the stated element."
    InvalidArrays "invalid-arrays"
        "A `.npz` or `.csv` file is broken, or its arrays differ from the arrays that `mocap fk` writes."
        "Write it again from its source."
    InvalidClip "invalid-clip"
        "The file is not a valid packed clip, or has a version that cannot be read."
        "Write it again from its source: `mocap convert`."
    InvalidDatabase "invalid-database"
        "The file is not a motion database, is damaged, or has a version that cannot be read."
        "Make it again with `mocap index`."
    InvalidGraph "invalid-graph"
        "The file is not a motion graph, is damaged, or one of its clips has changed."
        "Make the graph again with `mocap graph`."
    UnreadExtension "unread-extension"
        "The file requires an extension that cannot be read, but that does not affect its skeleton and motion."
        "Ignore this unless you need the meshes; otherwise write the file without the extension."
    FrameNumber "frame-number"
        "The frame numbers are not consecutive; the frames were read in the order of the file."
        "Number the frames again, or look for missing frames."
    Gap "gap"
        "Some frames have no value for a joint or a marker; its track has no key there."
        "Ignore this if interpolation is good enough; otherwise fill the gaps in the capture software."
    ClockJump "clock-jump"
        "The clock of a live motion sender jumped; the recording continues with the arrival times of the packets."
        "Ignore this, or compare the recording with its sound or video at the stated time."
    LooseMarker "loose-marker"
        "A marker is far from its position on the solved body, or its label is unknown."
        "Check it in the capture software: it may have a wrong label, be a reflection, or sit on clothes. Name \
            unknown labels with the option markers."
    SwappedMarkers "swapped-markers"
        "Two markers have each other's labels in some frames. The labels were exchanged there."
        "Ignore this, or correct the labels in the capture software."
    IgnoredChannel "ignored-channel"
        "The file has an animation without a standard meaning; it was skipped."
        "Check the motion."
    IgnoredMesh "ignored-mesh"
        "A mesh or a texture cannot be read, or its bones are unknown or contradict each other; it was skipped."
        "Bind or export the mesh again in the program that wrote the file."
    NotHumanoid "not-humanoid"
        "The skeleton is not a humanoid, or its hips are not the ancestor of all its bones."
        "Name the bones in a map, or choose another file."
    PosesApart "poses-apart"
        "Two motions that are joined or mixed differ much in pose or speed where they meet."
        "Cut them at similar poses, or choose other motions."
    NoMotion "no-motion"
        "The file has no frames, so the scene has a skeleton and no animation."
        "Ignore this if you need only the skeleton."
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

/// The names of the codes.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for Code {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Code".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let names: Vec<&str> = Self::ALL.iter().map(|code| code.as_str()).collect();
        schemars::json_schema!({"type": "string", "enum": names})
    }
}

impl<'de> Deserialize<'de> for Code {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let code = Self::ALL.iter().find(|code| code.as_str() == name);
        code.copied()
            .ok_or_else(|| D::Error::custom(format!("no diagnostic is called `{name}`")))
    }
}
