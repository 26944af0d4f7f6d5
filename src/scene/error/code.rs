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

            /// The name in kebab case. It does not change between versions.
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
        "The file needs a second file, which is missing, or several could be meant."
        "Put the second file beside this one, or name it, such as the skeleton of a motion with the option skeleton."
    OutputIsInput "output-is-input"
        "The output would replace one of the input files, perhaps through a link."
        "Name another output."
    OutputExists "output-exists"
        "The output would replace a file that may be a source: this program did not write it, or it was changed since."
        "Name another output, or say that the file is to be replaced, with the option force."
    UnknownFormat "unknown-format"
        "Neither the contents nor the extension belong to a format that can be read."
        "Name the format, or convert the file to BVH first."
    UnknownOption "unknown-option"
        "There is no option, no step and no key of this name."
        "Use one of the names in the help text."
    InvalidValue "invalid-value"
        "The value of an option is not valid, or not valid for this file."
        "Choose one of the values in the help text."
    EmptyFile "empty-file"
        "The file is empty."
        "Export or download it again."
    BinaryFile "binary-file"
        "The file holds bytes that a text file cannot hold."
        "Check that it is not compressed, and that it is what its name says."
    MissingKeyword "missing-keyword"
        "A section or a line that the format requires is missing."
        "Add it, or export the file again."
    UnexpectedToken "unexpected-token"
        "The format does not allow this word here."
        "Correct the word at the location named."
    UnexpectedEnd "unexpected-end"
        "The file ends inside a section."
        "The file is cut off: export or download it again."
    InvalidNumber "invalid-number"
        "A number is expected, and the word is not a number."
        "Correct the number at the location named."
    NonFiniteOffset "non-finite-offset"
        "An OFFSET, or a number of a bone in an Acclaim skeleton, is NaN, infinite, or 1e18 or more."
        "Correct the number at the location named."
    NumberRange "number-range"
        "A number is too large or too small to compute with: it is not finite, 1e18 or more, or a scale below 1e-12 that is not 0."
        "Correct the number, or export the file again."
    UnknownChannel "unknown-channel"
        "CHANNELS, or the dof or order of an Acclaim skeleton, names a channel that does not exist."
        "Use Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation, Xscale, Yscale or Zscale; in Acclaim's files tx, ty, tz, rx, ry, rz or l."
    ChannelCount "channel-count"
        "The number after CHANNELS is not the number of names that follow."
        "Correct the number, or complete the names."
    FrameTime "frame-time"
        "The frame time is missing, zero, negative, not a number, or not one that a motion can have: the frame rate is below 0.0001 or above 1,000,000 frames per second."
        "State the frame rate yourself, with the option retime."
    RowLength "row-length"
        "A row of the motion has more or fewer values than the hierarchy has channels."
        "Correct the row, or export the file again."
    LimitExceeded "limit-exceeded"
        "A count or a size in the file is larger than `Limits` allows."
        "Raise the limit if you trust the file."
    FrameCount "frame-count"
        "The motion has more frames than the file states, or keys outside the range that it states."
        "Correct the number or the range in the file; the option all-rows reads the rows of BVH beyond it."
    MissingFrames "missing-frames"
        "The motion has fewer frames than the file states: the file is cut off, or states a wrong number."
        "Export or download the file again. The frames that are there were read."
    HeaderCount "header-count"
        "A count or a range that the file states differs from its data; the data were read."
        "Export the file again."
    UnknownUnit "unknown-unit"
        "glTF is in metres, and the lengths of the scene are in another or an unknown unit; or markers fit no body in the unit that their file states."
        "Apply a `Conversion` before writing, or set `Metadata::metres_per_unit` to 1 where the lengths are metres."
    StatedOtherwise "stated-otherwise"
        "An option states another unit or another up axis of the input than the file does; the option was used."
        "Leave the option out if the file is right. Options of the output change what is written."
    ImplausibleSize "implausible-size"
        "By the unit that the file or an option states, the figure is far larger or smaller than a person."
        "State the right unit of the input, if the figure is a person."
    NonFiniteValue "non-finite-value"
        "A value of the motion is NaN, infinite, or 1e18 or more; the last value of its channel before it was used."
        "Repair the capture at the frames named."
    TrailingText "trailing-text"
        "Text, or lines with another number of values, follow the last row of the motion, or bytes its last table; they were ignored."
        "Remove it."
    RepeatedOffset "repeated-offset"
        "A joint has more than one OFFSET; the last one was used."
        "Remove all but one."
    LongOffset "long-offset"
        "An OFFSET has more than three numbers; the first three were used."
        "Remove the others."
    RepeatedChannels "repeated-channels"
        "A joint has more than one CHANNELS line; a line that repeats another was ignored, the others were joined."
        "Join them into one line."
    RepeatedChannel "repeated-channel"
        "A joint names a channel twice; rotations were multiplied, of positions and scales the last value was used."
        "Remove one of the two."
    DecimalComma "decimal-comma"
        "Numbers have a decimal comma; it was read as a decimal point."
        "Export with a locale that has decimal points."
    SplitNumber "split-number"
        "Two numbers have no space between them; they were split before the sign."
        "Put a space between them."
    MissingBrace "missing-brace"
        "MOTION begins before all joints are closed; they were closed there."
        "Add the closing braces."
    WorldPositions "world-positions"
        "The positions of joints below the root are far beyond the length of their OFFSETs: they seem to be positions in the world."
        "Export positions from the parent, or none but for the root."
    MissingMotion "missing-motion"
        "`Frames:` follows the hierarchy without MOTION; the rows after it were read."
        "Write MOTION before `Frames:`."
    NestedEndSite "nested-end-site"
        "An End Site stands within an End Site; it was read as its child."
        "Make the outer End Site a JOINT, or remove one of the two."
    ExtraBrace "extra-brace"
        "A closing brace has no opening brace; it was ignored."
        "Remove it."
    JointOutsideRoot "joint-outside-root"
        "A JOINT follows the closing brace of its ROOT; it was attached to the root."
        "Move the closing brace behind the joint."
    SeveralRoots "several-roots"
        "The hierarchy has more than one ROOT; they were put under one parent node."
        "Give each skeleton its own file if you want them apart."
    DuplicateName "duplicate-name"
        "Several nodes have one name; the names were kept, and each node has its own channel."
        "Rename them if another program finds nodes by name."
    ErrorBound "error-bound"
        "The chosen number format cannot keep the error below the limit."
        "Allow a larger error, or store 32-bit floats, without compression."
    MissingFeature "missing-feature"
        "The file needs a feature that this build does not have."
        "Build the program with the feature named."
    Unrepresentable "unrepresentable"
        "The scene holds something that the output format cannot hold."
        "Correct the scene at the node named, or leave that part out."
    NotCarriedOver "not-carried-over"
        "The input holds data that the output has not, because the reader or the format has no place for it."
        "Nothing, if you do not need it; otherwise write another format (docs/losses.md)."
    UnreadableFormat "unreadable-format"
        "The format is known, but cannot be read."
        "Export BVH or FBX from the program that wrote the file."
    InvalidFbx "invalid-fbx"
        "The file is not valid FBX."
        "Export or download it again."
    InvalidUsd "invalid-usd"
        "The file is not valid USD, or has no skeleton of UsdSkel."
        "Export it again, as one layer, for example with `usdcat`."
    InvalidMmd "invalid-mmd"
        "The file is not a valid model or motion of MikuMikuDance."
        "Export or download it again."
    InvalidGltf "invalid-gltf"
        "The file is not valid glTF, or requires an extension that cannot be read."
        "Write it again without required extensions, or check it with the Khronos validator."
    InvalidXml "invalid-xml"
        "The file is not valid XML."
        "Correct what is at the location named, or export the file again."
    InvalidRobot "invalid-robot"
        "The links and joints of a robot contradict each other, or a value of them is not valid."
        "Correct the element named."
    InvalidArrays "invalid-arrays"
        "A `.npz` or `.csv` file is broken, or its arrays are not those that `mocap fk` writes."
        "Write it again from its source."
    InvalidClip "invalid-clip"
        "The file is not a valid packed clip, or of a version that cannot be read."
        "Write it again from its source: `mocap convert`."
    InvalidDatabase "invalid-database"
        "The file is not a database of motions, is damaged, or is of a version that cannot be read."
        "Make it again with `mocap index`."
    InvalidGraph "invalid-graph"
        "The file is no motion graph, is damaged, or a clip has changed since it was made."
        "Make the graph again with `mocap graph`."
    UnreadExtension "unread-extension"
        "The file requires an extension that cannot be read and that does not affect its skeleton and motion."
        "Nothing, unless you need the meshes; otherwise write the file again without it."
    FrameNumber "frame-number"
        "The frame numbers are not consecutive; the frames were read in the order of the file."
        "Number the frames again, or look for missing frames."
    Gap "gap"
        "Some frames have no value for a joint or a marker; its track has no key there."
        "Nothing, if interpolation is good enough; otherwise fill the gaps in the capture software."
    ClockJump "clock-jump"
        "The clock of a sender of live motion jumped; the recording goes on by the time of arrival there."
        "Nothing, or compare the recording with its sound or video at the time named."
    LooseMarker "loose-marker"
        "A marker is far from where the body that was solved from all has it, or its label is not known."
        "Look at it in the capture software: it may be labelled wrongly, a reflection, or on clothes. Name unknown labels with the option markers."
    SwappedMarkers "swapped-markers"
        "Two markers have the labels of each other in some frames; they were exchanged there."
        "Nothing, or mend the labels in the capture software."
    IgnoredChannel "ignored-channel"
        "The file animates something that has no agreed meaning; it was left out."
        "Look at the motion and check it."
    IgnoredMesh "ignored-mesh"
        "A mesh or a texture cannot be read, or its bones are unknown or contradict each other; it was left out."
        "Bind or export the mesh again in the program that wrote the file."
    NotHumanoid "not-humanoid"
        "The skeleton is not a humanoid, or its hips are not above all of its bones."
        "Name the bones in a map, or choose another file."
    PosesApart "poses-apart"
        "Two motions that are joined or mixed are far apart there, in their poses or their speeds."
        "Cut them where they are alike, or choose other motions."
    NoMotion "no-motion"
        "The file has no frames, so the scene has a skeleton and no animation."
        "Nothing, if a skeleton is all you need."
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
