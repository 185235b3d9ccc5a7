'use strict';
// Pictures of a wall swing while the pointer or the focus is on them; where no pointer hovers, those in the middle of
// the screen do. Nothing moves by itself for readers who ask for less motion.
{
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  const still = image => image.dataset.still ||= image.getAttribute('src');
  const swing = (image, wanted) => {
    const source = wanted && !calm.matches ? still(image).replace(/\.svg$/, '.swing.svg') : still(image);
    if (image.getAttribute('src') !== source) image.src = source;
  };
  const image = event => event.target.closest?.('.wall a')?.querySelector('img[data-swings]');
  const images = document.querySelectorAll('.wall img[data-swings]');
  if (matchMedia('(hover: hover)').matches) {
    for (const [name, wanted] of [['pointerover', true], ['pointerout', false]]) {
      addEventListener(name, event => {
        const found = image(event), other = event.relatedTarget;
        if (found && !found.closest('a').contains(other)) swing(found, wanted);
      });
    }
  } else {
    const middle = new IntersectionObserver(entries => {
      for (const entry of entries) swing(entry.target, entry.isIntersecting);
    }, {rootMargin: '-42% 0px'});
    for (const one of images) middle.observe(one);
  }
  for (const [name, wanted] of [['focusin', true], ['focusout', false]]) {
    addEventListener(name, event => { const found = image(event); if (found) swing(found, wanted); });
  }

  const button = document.querySelector('.pause');
  if (button) {
    const sources = [...document.querySelectorAll('.first source')], moving = sources[0].media;
    let paused = calm.matches;
    const show = () => {
      for (const source of sources) source.media = paused ? 'not all' : calm.matches ? 'all' : moving;
      button.textContent = paused ? 'Play' : 'Pause';
    };
    button.addEventListener('click', () => { paused = !paused; show(); });
    button.hidden = false;
    show();
  }
}
