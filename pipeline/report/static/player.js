'use strict';
// The swing of a transform's page: play and pause, a slider, and pieces that turn as they are dragged.
{
  const player = document.querySelector('.player'), picture = player?.querySelector('svg.swing');

  // Where a piece lies in each frame of the way from P to Q: translation and turn, in degrees.
  const frames = (group, first, last) => {
    const [move, turn] = ['translate', 'rotate'].map(type =>
      group.querySelector(`animateTransform[type=${type}]`).getAttribute('values').split(';').slice(first, last + 1));
    return move.map((pair, k) => [...pair.split(' ').map(Number), +turn[k] * Math.PI / 180]);
  };
  const placed = ([x, y, turn], point) => ({
    x: x + point.x * Math.cos(turn) - point.y * Math.sin(turn),
    y: y + point.x * Math.sin(turn) + point.y * Math.cos(turn),
  });
  const back = ([x, y, turn], point) => placed([0, 0, -turn], {x: point.x - x, y: point.y - y});

  if (picture?.setCurrentTime) {
    const {start, end, mirror, duration} = Object.fromEntries(
      Object.entries(player.dataset).map(([name, value]) => [name, +value]));
    const bar = player.querySelector('.bar'), [button, slider] = ['button', 'input'].map(one => bar.querySelector(one));
    const values = picture.querySelector('animateTransform').getAttribute('values').split(';').length - 1;
    const frame = time => Math.round(time / duration * values);
    const first = frame(start), last = frame(end);
    let plays = false;

    const follow = () => {
      if (!plays) return;
      const time = picture.getCurrentTime() % duration;
      slider.value = (Math.min(time, mirror - time) - start) / (end - start);
      requestAnimationFrame(follow);
    };
    const play = wanted => {
      plays = wanted;
      button.textContent = plays ? 'Pause' : 'Play';
      if (plays) picture.unpauseAnimations(); else picture.pauseAnimations();
      follow();
    };
    const show = way => {
      if (plays) play(false);
      slider.value = way;
      picture.setCurrentTime(start + slider.valueAsNumber * (end - start));
    };
    button.addEventListener('click', () => play(!plays));
    slider.addEventListener('input', () => show(slider.valueAsNumber));

    // The piece keeps the point that is held as near to the pointer as its way leads.
    const here = event => new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
    const between = (one, next, share) => one.map((value, k) => value + share * (next[k] - value));
    let held = null;
    const drag = event => {
      const pointer = here(event), {way, point} = held;
      const distance = k => {
        const low = Math.min(Math.floor(k), way.length - 2), at = placed(between(way[low], way[low + 1], k - low), point);
        return Math.hypot(at.x - pointer.x, at.y - pointer.y);
      };
      const now = slider.valueAsNumber * (way.length - 1);
      let best = now;
      // Not far ahead at once: a way may pass the same place twice.
      for (let k = Math.max(0, now - 6); k <= Math.min(way.length - 1, now + 6); k += 0.1) {
        if (distance(k) < distance(best)) best = k;
      }
      show(best / (way.length - 1));
    };
    picture.addEventListener('pointerdown', event => {
      const group = event.target.closest('.r-move > g');
      if (!group || event.button) return;
      play(false);
      show(Math.max(0, Math.min(1, slider.valueAsNumber)));
      const way = frames(group, first, last), now = slider.valueAsNumber * (way.length - 1);
      const low = Math.min(Math.floor(now), way.length - 2);
      held = {way, point: back(between(way[low], way[low + 1], now - low), here(event))};
      picture.setPointerCapture(event.pointerId);
      player.classList.add('held');
      event.preventDefault();
    });
    picture.addEventListener('pointermove', event => { if (held) drag(event); });
    for (const name of ['pointerup', 'pointercancel']) {
      picture.addEventListener(name, () => { held = null; player.classList.remove('held'); });
    }

    player.classList.add('ready');
    bar.hidden = player.querySelector('.hint').hidden = false;
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) show(0.35); else play(true);
    button.textContent = plays ? 'Pause' : 'Play';
  }

  const command = document.querySelector('.command'), copy = command?.querySelector('button');
  if (copy && navigator.clipboard) {
    copy.hidden = false;
    copy.addEventListener('click', async () => {
      await navigator.clipboard.writeText(command.querySelector('code').textContent);
      copy.textContent = 'Copied';
    });
  }
}
