//! Options of `record`, `play` and `bridge`.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::str::FromStr;

use mocap::job::InputOptions;

use super::ForceArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct RecordArgs {
    /// The source of the motion: vmc:PORT for a sender on this machine, or vmc:ADDRESS:PORT to listen on an address of
    /// this machine, such as vmc:0.0.0.0:39539 for senders on the network
    #[arg(value_name = "INPUT")]
    pub(crate) source: ListenAddress,
    /// The file to write, in any written format
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// End after this number of seconds [default: at Ctrl-C]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<f64>,
    /// Clean the recording, as `mocap clean` does, before writing it
    #[arg(long)]
    pub(crate) clean: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PlayArgs {
    /// The motion file of a humanoid; - is standard input. With --clean or --robot, also a live stream: vmc:PORT or
    /// vmc:ADDRESS:PORT
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// Send the motion over the VMC protocol to this address and port; without an address, to this machine
    #[arg(long, value_name = "HOST:PORT", required_unless_present = "robot")]
    pub(crate) vmc: Option<Peer>,
    /// Retarget the motion to this robot, a .urdf file or a MuJoCo .xml file, and print a row for each frame, 0.6
    /// seconds later. As in mocap robot --to unitree-csv, a row has the position and rotation (x y z w) of the base,
    /// then the joints
    #[arg(long, value_name = "TARGET", conflicts_with = "vmc")]
    pub(crate) robot: Option<PathBuf>,
    /// Loop the motion until Ctrl-C; needs --vmc
    #[arg(long = "loop")]
    pub(crate) repeat: bool,
    /// Poses per second [default: the rate of the file]
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// Clean the motion: a file as `mocap clean` does; of a stream, remove only the noise
    #[arg(long)]
    pub(crate) clean: bool,
    /// Delay of a stream in seconds, from 0 to 10. A longer delay removes more noise [default: 0.5]
    #[arg(long, value_name = "SECONDS", value_parser = delay, requires = "clean")]
    pub(crate) delay: Option<f64>,
    /// Print the report as JSON
    #[arg(long, conflicts_with = "robot")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct BridgeArgs {
    /// The source of the motion: vmc:PORT for a sender on this machine, or vmc:ADDRESS:PORT to listen on an address of
    /// this machine, such as vmc:0.0.0.0:39539 for senders on the network
    #[arg(value_name = "INPUT")]
    pub(crate) source: ListenAddress,
    /// The character or robot to move: a glTF, VRM or any other file with a humanoid, or a robot of URDF or MJCF
    #[arg(long = "character", visible_alias = "robot", alias = "onto", value_name = "TARGET")]
    pub(crate) onto: PathBuf,
    /// Send the motion over the VMC protocol to this address and port; without an address, to this machine
    #[arg(
        long,
        value_name = "HOST:PORT",
        required_unless_present = "udp_json",
        conflicts_with = "udp_json"
    )]
    pub(crate) vmc: Option<Peer>,
    /// Send the motion as JSON to this address and port, one UDP packet for each pose
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) udp_json: Option<Peer>,
    /// Remove noise from the stream before retargeting
    #[arg(long)]
    pub(crate) clean: bool,
    /// Delay in seconds, from 0 to 10. A longer delay removes more noise [default: 0.5]
    #[arg(long, value_name = "SECONDS", value_parser = delay, requires = "clean")]
    pub(crate) delay: Option<f64>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// The address and the port to listen on.
#[derive(Clone, Copy, Debug)]
pub struct ListenAddress(pub(crate) SocketAddr);

impl FromStr for ListenAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let rest = text.strip_prefix("vmc:");
        let rest = rest.ok_or("not vmc:PORT or vmc:ADDRESS:PORT, such as vmc:39539")?;
        resolved(rest).map(Self)
    }
}

/// The address and the port to send to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) SocketAddr);

impl FromStr for Peer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match resolved(text)? {
            peer if peer.port() == 0 => Err("a port is from 1 to 65535".to_owned()),
            peer => Ok(Self(peer)),
        }
    }
}

/// Parses a port of this machine, or an address and a port.
fn resolved(text: &str) -> Result<SocketAddr, String> {
    if let Ok(port) = text.parse() {
        return Ok(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    }
    let found = text.to_socket_addrs().ok().and_then(|mut found| found.next());
    found.ok_or_else(|| format!("{text} is neither a port nor an address and a port, such as 127.0.0.1:39539"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.ok_or_else(|| "not a number of seconds from 0 to 1000000".to_owned())
}

fn delay(text: &str) -> Result<f64, String> {
    let delay = text.parse().ok().filter(|delay| (0.0..=10.0).contains(delay));
    delay.ok_or_else(|| "not a number of seconds from 0 to 10".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "not a number of poses per second from 0.1 to 1000".to_owned())
}
