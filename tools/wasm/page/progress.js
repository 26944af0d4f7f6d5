// How far a request is: its stages, and what waits.

import { byId } from "../../../src/render/view/dom.js";

const STAGES = {
  starting: "starting", reading: "reading", parsing: "understanding", editing: "changing", retargeting: "putting on the character", packing: "preparing the picture", writing: "writing",
};

/** The stages of each call, in their order; the bar has a part for each. */
const OF_CALL = {
  inspect: ["reading", "parsing"],
  show: ["reading", "parsing", "editing", "retargeting", "packing"],
  save: ["reading", "parsing", "editing", "retargeting", "writing"],
};

/** What is done within these milliseconds needs no bar. */
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
    // What nobody waits for is no cover over the picture.
    byId("work").classList.toggle("aside", request.call === "inspect");
    if (byId("work").hidden) this.soon = setTimeout(() => { byId("work").hidden = false; }, SOON);
  }

  // The part of a call that is done: its stages before this one, and what is done of this one.
  done({ call, item }, stage, share = 0) {
    const isDone = { editing: item?.steps?.length, retargeting: item?.onto };
    const stages = (OF_CALL[call] ?? []).filter((name) => !(name in isDone) || isDone[name]);
    return (Math.max(0, stages.indexOf(stage)) + share) / Math.max(1, stages.length);
  }
}
