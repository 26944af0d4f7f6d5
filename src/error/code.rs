//! The table of codes: what each means, where it comes from, and what to do.

use std::fmt;

use serde::{Serialize, Serializer};

/// Declares [`Code`] from one table, so that a code, its name, its cause and its remedy cannot drift apart.
macro_rules! codes {
    ($($variant:ident $name:literal $cause:literal $remedy:literal)*) => {
        /// The stable name of a diagnostic.
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
            /// Every code, in the order of the table.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Its name in kebab case, which does not change between versions.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What brings it about.
            pub const fn cause(self) -> &'static str {
                match self { $(Self::$variant => $cause,)* }
            }

            /// What to do about it.
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
        "The file needs another one beside it, which is not there or cannot be told from others."
        "Put it beside this one, or name it: `--skeleton` or `Importer::skeleton` for the skeleton of a motion."
    UnknownFormat "unknown-format"
        "Neither the contents nor the name say a format that is read here."
        "Name the format, or convert the file to BVH first."
    UnknownOption "unknown-option"
        "An option has a value that does not go with this file."
        "See the help text for the values it takes."
    EmptyFile "empty-file"
        "The file holds no text."
        "Export or download it again."
    BinaryFile "binary-file"
        "The file holds bytes that no text file has."
        "Check that it is not compressed, and that it is what its name says."
    MissingKeyword "missing-keyword"
        "A section or a line that the format requires is absent."
        "Add it, or export the file again."
    UnexpectedToken "unexpected-token"
        "A word stands where the format allows other words only."
        "Correct the word at the place named."
    UnexpectedEnd "unexpected-end"
        "The file ends inside a section."
        "The file is cut off: export or download it again."
    InvalidNumber "invalid-number"
        "Something that is not a number stands where a number belongs."
        "Correct the number at the place named."
    NonFiniteOffset "non-finite-offset"
        "An OFFSET, or a number of a bone in an Acclaim skeleton, is NaN, infinite or beyond 1e18, so the joint has no place."
        "Correct the number at the place named."
    UnknownChannel "unknown-channel"
        "CHANNELS, or the dof or order of an Acclaim skeleton, names a channel that does not exist."
        "Use Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation, Xscale, Yscale or Zscale; in Acclaim's files tx, ty, tz, rx, ry, rz or l."
    ChannelCount "channel-count"
        "The number after CHANNELS is not the number of names that follow."
        "Make the two agree."
    FrameTime "frame-time"
        "The frame time is missing, zero, negative or not a number."
        "State the frame rate yourself, with `--fps` or `Importer::frame_rate`."
    RowLength "row-length"
        "A row of the motion has more or fewer values than the hierarchy has channels."
        "Correct the row, or export the file again."
    LimitExceeded "limit-exceeded"
        "The file claims more than `Limits` allows."
        "Raise the limit if you trust the file."
    FrameCount "frame-count"
        "The motion has more or fewer rows than `Frames:` says."
        "Correct `Frames:`; `--all-rows` reads the rows beyond it."
    NonFiniteValue "non-finite-value"
        "A value of the motion is NaN or infinite; the last finite value of its channel was held."
        "Repair the capture at the frames named."
    TrailingText "trailing-text"
        "Text follows the last row of the motion; it was ignored."
        "Remove it."
    RepeatedOffset "repeated-offset"
        "A joint has more than one OFFSET; the last one was taken."
        "Remove all but one."
    RepeatedChannels "repeated-channels"
        "A joint has more than one CHANNELS line; one that repeats another was ignored, others follow one another."
        "Join them into one line."
    RepeatedChannel "repeated-channel"
        "A joint names one channel twice; rotations multiply, of the others the last value was taken."
        "Remove one of the two."
    DecimalComma "decimal-comma"
        "Numbers are written with a decimal comma; it was read as a point."
        "Export with a locale that has decimal points."
    SplitNumber "split-number"
        "Two numbers stand together without a space; they were split before the sign."
        "Put a space between them."
    MissingBrace "missing-brace"
        "MOTION comes before every joint is closed; the joints were closed there."
        "Add the closing braces."
    ExtraBrace "extra-brace"
        "A closing brace closes nothing; it was ignored."
        "Remove it."
    JointOutsideRoot "joint-outside-root"
        "A JOINT stands after its ROOT is closed; it was attached to the root."
        "Move the closing brace behind it."
    SeveralRoots "several-roots"
        "The hierarchy has more than one ROOT; they were put under one parent node."
        "Give each skeleton its own file if you want them apart."
    DuplicateName "duplicate-name"
        "Several nodes have the same name; each kept it, and is driven by its own channels."
        "Rename them if another program finds nodes by name."
    ErrorBound "error-bound"
        "The largest error that is allowed is less than what the chosen numbers can keep."
        "Allow a larger error, or store 32-bit floats: `--compress none`."
    MissingFeature "missing-feature"
        "The file needs a part that this build of the program was made without."
        "Build it again with the feature named."
    Unrepresentable "unrepresentable"
        "The scene holds something that the output format has no place for."
        "Mend the scene at the node named, or leave that part out."
    UnreadableFormat "unreadable-format"
        "The format is known and not read here."
        "Export BVH or FBX from the program that wrote the file."
    InvalidFbx "invalid-fbx"
        "The file is not valid FBX."
        "Export or download it again."
    InvalidGltf "invalid-gltf"
        "The file is not valid glTF, or needs an extension that is not read here."
        "Write it again without extensions that a reader must know, or check it with the Khronos validator."
    Interpolation "interpolation"
        "A track steps or bends between its keys; the way was taken to be straight."
        "Write the animation with linear interpolation."
    FrameNumber "frame-number"
        "The frames are not numbered one by one; they were taken in the order of the file."
        "Number them anew, or look for frames that are missing."
    Gap "gap"
        "Some frames say nothing about a joint or a marker; its track has no key there."
        "Nothing, if what stands before and after is enough; else fill the gaps where the capture was made."
    IgnoredChannel "ignored-channel"
        "The file moves something in a way that has no agreed meaning; it was left out."
        "Check the motion by eye."
    IgnoredMesh "ignored-mesh"
        "The bones of a mesh cannot be told, or agree on no place where it was bound to them; it was left out."
        "Bind the mesh again in the program that wrote the file."
    NoMotion "no-motion"
        "There is no frame, so the scene has a skeleton and no animation."
        "Nothing, if a skeleton is what you want."
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
