// <mocap-player src="walk.bvh" character="hero.vrm">: the player of the drop page as an element. The element fetches the files,
// and passes their bytes to the page in its iframe, which has no network access. The types are in player.d.ts.

const nameOf = (address) => decodeURIComponent(new URL(address, document.baseURI).pathname.split("/").pop()) || "motion.bvh";

async function fileOf(address) {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}`);
  return { name: nameOf(address), bytes: await response.arrayBuffer() };
}

const Base = globalThis.HTMLElement ?? class {};

export class MocapPlayer extends Base {
  static observedAttributes = ["src", "character", "speed", "loop", "paused", "theme"];
  #frame;
  #ready;
  /** The last requested load. */
  #wanted;
  #now = { seconds: 0, duration: 0, playing: false };

  connectedCallback() {
    if (this.#frame) return;
    const shadow = this.shadowRoot ?? this.attachShadow({ mode: "open" });
    shadow.innerHTML = "<style>:host { display: block; height: 360px } iframe { display: block; width: 100%; height: 100%; border: 0 }</style>";
    const frame = document.createElement("iframe");
    frame.title = this.getAttribute("aria-label") ?? "A motion";
    // Allow scripts and downloads, but no access to the enclosing page.
    frame.sandbox = "allow-scripts allow-downloads";
    frame.src = `${new URL(this.getAttribute("page") ?? new URL("player.html", import.meta.url), document.baseURI)}#embedded`;
    this.#frame = frame;
    this.#ready = new Promise((done) => { this.#hear = ({ source, data }) => source === frame.contentWindow && data?.mocap && this.#take(data, done); });
    addEventListener("message", this.#hear);
    shadow.append(frame);
    this.#load();
  }

  #hear;

  disconnectedCallback() {
    removeEventListener("message", this.#hear);
    this.#frame?.remove();
    this.#frame = this.#ready = undefined;
  }

  attributeChangedCallback(name, before, value) {
    if (!this.#frame || before === value) return;
    if (name === "src" || name === "character") this.#load();
    else this.#tell({ settings: this.#settings });
  }

  get #settings() {
    return { speed: Number(this.getAttribute("speed")) || 1, loop: this.getAttribute("loop") !== "false", paused: this.hasAttribute("paused"), theme: this.getAttribute("theme") };
  }

  async #load() {
    const addresses = [this.getAttribute("src"), this.getAttribute("character")].filter(Boolean);
    if (addresses.length === 0) return;
    const wanted = (this.#wanted = {});
    // Attributes that are set together cause one load.
    await Promise.resolve();
    try {
      const files = await Promise.all(addresses.map(fileOf));
      if (wanted === this.#wanted) this.#tell({ open: files, settings: this.#settings });
    } catch (error) {
      if (wanted === this.#wanted) this.#say("error", { message: error.message });
    }
  }

  async #tell(message) {
    await this.#ready;
    this.#frame?.contentWindow.postMessage({ mocap: "do", ...message }, "*");
  }

  #take({ mocap, ...detail }, done) {
    if (mocap === "ready") done();
    if (mocap === "time") this.#now = detail;
    if (mocap === "load") this.#now = { ...this.#now, duration: detail.duration };
    this.#say(mocap === "time" ? "timeupdate" : mocap, detail);
  }

  #say(type, detail) { this.dispatchEvent(new CustomEvent(type, { detail })); }

  play() { this.removeAttribute("paused"); this.#tell({ settings: this.#settings }); }
  pause() { this.setAttribute("paused", ""); }
  get paused() { return !this.#now.playing; }
  get duration() { return this.#now.duration; }
  get currentTime() { return this.#now.seconds; }
  set currentTime(seconds) { this.#tell({ seek: seconds }); }
}

globalThis.customElements?.get("mocap-player") ?? globalThis.customElements?.define("mocap-player", MocapPlayer);
