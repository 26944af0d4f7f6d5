// The page's side of the reading worker. Sends requests one by one, urgent requests first, and replaces an ended worker.

/** After these errors the state of the worker is undefined. */
const ENDED = new Set(["defect", "out-of-memory", "stopped"]);

export class Reader {
  // `wasm` is a promise of the module's bytes. `progress` is called with the current request and its stage, or with nothing.
  // `restarted` is called with the reason.
  constructor({ script, wasm, progress, restarted }) {
    this.address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
    Object.assign(this, { wasm, progress, restarted });
    this.waiting = [];
    this.last = 0;
    this.start();
  }

  start() {
    const worker = new Worker(this.address);
    this.worker = worker;
    this.isReady = false;
    worker.onmessage = ({ data }) => this.take(data);
    worker.onerror = (event) => {
      event.preventDefault();
      const error = { code: "defect", message: event.message || "the browser starts no worker from this page" };
      // A worker that never started would not start the next time either.
      if (this.isReady) this.end(error);
      else this.giveUp(error);
    };
    this.wasm.then(
      (wasm) => worker === this.worker && worker.postMessage({ wasm }),
      (error) => this.giveUp({ code: "defect", message: error.message }),
    );
  }

  // Returns a promise of the answer. The promise is rejected with the worker's error.
  ask(request, { isUrgent = true } = {}) {
    return new Promise((done, failed) => {
      if (this.broken) return failed(this.broken);
      const asked = { request: { ...request, id: ++this.last }, done, failed, isUrgent };
      const place = isUrgent ? this.waiting.findIndex((other) => !other.isUrgent) : -1;
      this.waiting.splice(place < 0 ? this.waiting.length : place, 0, asked);
      this.next();
    });
  }

  next() {
    if (this.working || !this.isReady || !this.waiting.length) return;
    this.working = this.waiting.shift();
    this.worker.postMessage(this.working.request);
    this.progress(this.working.request, "starting");
  }

  take({ ready, warm, id, stage, share, answer, error }) {
    if (ready) this.isReady = true;
    if (warm) this.isWarm = true;
    if (stage && this.working?.request.id === id) this.progress(this.working.request, stage, share);
    if (ready || warm || stage) return this.next();
    if (ENDED.has(error?.code)) return this.end(error);
    if (error) this.fail(error);
    else this.settle((working) => working.done(answer));
  }

  // Fails all requests, because there is no reader.
  giveUp(error) {
    this.broken = error;
    this.restarted(error);
    for (const { failed } of this.waiting.splice(0)) failed(error);
    this.fail(error);
  }

  fail(error) { this.settle((working) => working.failed(error)); }

  settle(tell) {
    const { working } = this;
    this.working = null;
    this.progress(null);
    if (working) tell(working);
    this.next();
  }

  // Ends the worker with its current request, and starts another worker.
  end(error) {
    this.worker.terminate();
    this.start();
    this.restarted(error);
    this.fail(error);
  }

  // Tells the worker to free the scenes of a file.
  forget(id) { if (this.isReady) this.worker.postMessage({ forget: id }); }

  stop() {
    if (this.working) this.end({ code: "stopped", message: "stopped" });
  }
}
