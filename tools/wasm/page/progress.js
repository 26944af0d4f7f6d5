// Shows the progress of a request: its stages, and waiting requests.

import { byId } from "../../../src/render/view/dom.js";

const STAGES = {
  starting: "starting", reading: "reading", parsing: "understanding", editing: "changing", retargeting: "retargeting", packing: "preparing the picture", writing: "writing",
};

/** The stages of each call in order. The bar has a part for each stage. */
const OF_CALL = {
  inspect: ["reading", "parsing"],
  show: ["reading", "parsing", "editing", "retargeting", "packing"],
  save: ["reading", "parsing", "editing", "retargeting", "writing"],
};

/** Requests that take less than this number of milliseconds show no bar. */
const SOON = 120;

export class Progress {
  show(request, stage, share, items) {
    clearTimeout(this.soon);
    if (!request) {
      byId("work").hidden = true;
      return;
    }
    const item = items.find(({ id }) => id === request.item?.id);
    const waiting = items.filter(({ state }) => state === "waiting").length;
    const count = waiting > 1 ? `${items.length - waiting + 1} of ${items.length}: ` : "";
    byId("work-text").textContent = `${count}${item?.name ?? ""}, ${STAGES[stage]}`;
    byId("work-bar").value = waiting > 1 ? 1 - waiting / items.length : this.done(request, stage, share);
    // A background request does not cover the picture.
    byId("work").classList.toggle("aside", request.call === "inspect");
    if (byId("work").hidden) this.soon = setTimeout(() => { byId("work").hidden = false; }, SOON);
  }

  // The finished fraction of a call: all earlier stages, and a share of the current stage.
  done({ call, item }, stage, share = 0) {
    const isDone = { editing: item?.steps?.length, retargeting: item?.onto };
    const stages = (OF_CALL[call] ?? []).filter((name) => !(name in isDone) || isDone[name]);
    return (Math.max(0, stages.indexOf(stage)) + share) / Math.max(1, stages.length);
  }
}
