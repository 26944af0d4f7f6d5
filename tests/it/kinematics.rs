//! Forward kinematics of a BVH file, in double precision, directly from its text.
//!
//! The tests compare the library with this module, which shares no code with the library. The module reads lines, and
//! the library reads tokens. The module has 3x3 matrices instead of quaternions, and no single precision. It reads
//! plain files, not every dialect: a fixture in a dialect is compared with plain text of the same meaning.
//!
//! The position of a joint is `parent_position + parent_rotation * local`. `local` is the joint's OFFSET, with the
//! value of each position channel in place of the OFFSET's component. The rotation of a joint is `parent_rotation * R1
//! * R2 * R3`: the rotation channels in the order of CHANNELS.

/// A point or a direction.
pub(crate) type Vector = [f64; 3];

/// Rows of a 3x3 matrix that maps column vectors.
pub(crate) type Matrix = [[f64; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The effect of a root's position channels on its OFFSET.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Root {
    Replace,
    Add,
}

/// The effect of a column of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    Position(usize),
    Rotation(usize),
}

/// A joint or an end site.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) name: String,
    pub(crate) parent: Option<usize>,
    pub(crate) offset: Vector,
    pub(crate) columns: Vec<Column>,
}

/// The contents of a file.
#[derive(Clone, Debug)]
pub(crate) struct Capture {
    /// Depth-first, in the order of the file.
    pub(crate) nodes: Vec<Node>,
    pub(crate) frame_time: f64,
    /// One value per column, one `Vec` per frame.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// The position and the rotation of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) rotation: Matrix,
    pub(crate) position: Vector,
}

impl Capture {
    /// Reads a file that has each keyword and each frame on a separate line.
    ///
    /// A NaN becomes the value of the row before, or zero in the first row. A joint that repeats CHANNELS word for word
    /// has these channels once.
    pub(crate) fn parse(bytes: &[u8]) -> Self {
        let text: String = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
        };
        let mut lines = text.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty());
        let nodes = parse_hierarchy(&mut lines);

        let mut frames = 0;
        let mut frame_time = 0.0;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for line in lines {
            if let Some(count) = line.strip_prefix("Frames:") {
                frames = count.trim().parse().unwrap();
            } else if let Some(seconds) = line.strip_prefix("Frame Time:") {
                frame_time = seconds.trim().parse().unwrap();
            } else if rows.len() < frames {
                let mut row: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
                for (column, value) in row.iter_mut().enumerate() {
                    if !value.is_finite() {
                        *value = rows.last().map_or(0.0, |before| before[column]);
                    }
                }
                rows.push(row);
            }
        }
        let width: usize = nodes.iter().map(|node| node.columns.len()).sum();
        assert!(
            rows.iter().all(|row| row.len() == width),
            "a row has not {width} values"
        );
        Self {
            nodes,
            frame_time,
            rows,
        }
    }

    /// The positions of all nodes in `frame`, in the order of `nodes`.
    pub(crate) fn placements(&self, frame: usize, root: Root) -> Vec<Placement> {
        self.place(Some(&self.rows[frame]), root)
    }

    /// The positions of all nodes in the rest pose.
    pub(crate) fn rest(&self) -> Vec<Placement> {
        self.place(None, Root::Replace)
    }

    fn place(&self, row: Option<&Vec<f64>>, root: Root) -> Vec<Placement> {
        let mut placements: Vec<Placement> = Vec::with_capacity(self.nodes.len());
        let mut first_column = 0;
        for node in &self.nodes {
            let mut local = node.offset;
            let mut rotation = IDENTITY;
            if let Some(row) = row {
                for (column, &value) in node.columns.iter().zip(&row[first_column..]) {
                    match *column {
                        Column::Position(axis) if node.parent.is_none() && root == Root::Add => {
                            local[axis] = node.offset[axis] + value;
                        }
                        Column::Position(axis) => local[axis] = value,
                        Column::Rotation(axis) => rotation = multiply(rotation, turn(axis, value)),
                    }
                }
            }
            first_column += node.columns.len();
            placements.push(match node.parent {
                Some(parent) => placements[parent].then(Placement {
                    rotation,
                    position: local,
                }),
                None => Placement {
                    rotation,
                    position: local,
                },
            });
        }
        placements
    }

    /// The longest side of the box around the skeleton, at rest or in the first frame, whichever is longer. In some
    /// files all OFFSETs are zero.
    pub(crate) fn height(&self, root: Root) -> f64 {
        let mut poses = vec![self.rest()];
        if !self.rows.is_empty() {
            poses.push(self.placements(0, root));
        }
        poses.iter().map(|pose| longest_side(pose)).fold(0.0, f64::max)
    }
}

impl Placement {
    /// The placement of `child`, which is given relative to this placement.
    pub(crate) fn then(self, child: Self) -> Self {
        Self {
            rotation: multiply(self.rotation, child.rotation),
            position: self.point(child.position),
        }
    }

    /// The world position of a point that is fixed to this node.
    pub(crate) fn point(self, point: Vector) -> Vector {
        std::array::from_fn(|i| {
            let [x, y, z] = self.rotation[i];
            self.position[i] + x * point[0] + y * point[1] + z * point[2]
        })
    }
}

/// The rotation about axis 0, 1 or 2 (x, y or z) by `degrees`, counter-clockwise as seen from the tip of the axis.
pub(crate) fn turn(axis: usize, degrees: f64) -> Matrix {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut matrix = IDENTITY;
    matrix[next][next] = cos;
    matrix[next][last] = -sin;
    matrix[last][next] = sin;
    matrix[last][last] = cos;
    matrix
}

/// The matrix that applies `b` first, then `a`.
pub(crate) fn multiply(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum()))
}

/// The distance of two points.
pub(crate) fn distance(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn longest_side(pose: &[Placement]) -> f64 {
    let side = |axis: usize| {
        let along = || pose.iter().map(|placement| placement.position[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}

fn parse_hierarchy<'a>(lines: &mut impl Iterator<Item = &'a str>) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for line in lines {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match keyword {
            "HIERARCHY" | "{" => {}
            "ROOT" | "JOINT" | "End" => {
                let parent = open.last().copied();
                let is_end_site = keyword == "End";
                let name = if is_end_site {
                    format!("EndSite_{}", nodes[parent.unwrap()].name)
                } else {
                    rest.to_owned()
                };
                open.push(nodes.len());
                nodes.push(Node {
                    name,
                    parent,
                    offset: [0.0; 3],
                    columns: Vec::new(),
                });
            }
            "OFFSET" => {
                let numbers: Vec<f64> = rest.split_whitespace().map(|word| word.parse().unwrap()).collect();
                nodes[*open.last().unwrap()].offset = numbers.try_into().unwrap();
            }
            "CHANNELS" => {
                let mut words = rest.split_whitespace();
                let count: usize = words.next().unwrap().parse().unwrap();
                let columns: Vec<Column> = words.map(column).collect();
                assert_eq!(columns.len(), count, "{line}");
                nodes[*open.last().unwrap()].columns = columns;
            }
            "}" => {
                open.pop();
            }
            "MOTION" => break,
            _ => panic!("not a plain line: {line}"),
        }
    }
    nodes
}

fn column(name: &str) -> Column {
    let axis = "XYZ".find(&name[..1]).unwrap();
    match &name[1..] {
        "position" => Column::Position(axis),
        "rotation" => Column::Rotation(axis),
        _ => panic!("not a plain channel: {name}"),
    }
}
